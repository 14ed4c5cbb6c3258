// What instruments of the simulated field say when they are spoken to, each in its own protocol, and how they then send.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "drivers/wire/fastrak.h"
#include "synthesis/instruments/led_board.h"
#include "synthesis/instruments/magnetic_tracker.h"
#include "synthesis/instruments/serial_device.h"

namespace roseau::synthesis {

/// One thread at a time. Times are the scene's, in seconds.
class Console {
 public:
  virtual ~Console() = default;
  /// Takes what the host has sent; gives what the instrument answers at once.
  virtual std::string take(std::string_view received, double time_s) = 0;
  /// The bytes of record `number` as the instrument is set up now; empty while it does not send.
  virtual std::string record(std::uint64_t number, double time_s) = 0;
};

/// An instrument that sends by itself and listens to nobody: a sonic in continuous mode.
class DeafConsole final : public Console {
 public:
  explicit DeafConsole(std::shared_ptr<const SerialInstrument> instrument) : instrument_(std::move(instrument)) {}
  std::string take(std::string_view, double) override { return {}; }
  std::string record(std::uint64_t number, double) override { return instrument_->record(number); }

 private:
  std::shared_ptr<const SerialInstrument> instrument_;
};

/// A FASTRAK as it is delivered: text, inches, items 2,4,1, silent until told to send. Commands, case-sensitive: C and c begin
/// and end sending, P asks for one record of each station, F text, f binary, U inches, u centimetres, O<n>,<items> CR, l<n> CR
/// and l<n>,<0|1> CR stations in use, S status, W as delivered, ^Y reset (then silent for ten seconds); other commands of the
/// manual are accepted and change nothing; what is none is answered with an error.
class FastrakConsole final : public Console {
 public:
  static constexpr double kReset_s = 10;

  explicit FastrakConsole(std::shared_ptr<const MagneticTracker> tracker);

  std::string take(std::string_view received, double time_s) override;
  std::string record(std::uint64_t number, double time_s) override;

 private:
  std::string take_letter(char letter, double time_s);
  std::string run(std::string_view command);
  std::string set_items(std::string_view arguments);
  std::string set_station(std::string_view arguments);
  std::string status() const;
  std::string record_now(std::uint64_t number) const;
  std::string records_of_all(double time_s) const;
  void set_as_delivered();
  bool has_station(int station) const { return station >= 1 && station <= tracker_->station_count(); }

  std::shared_ptr<const MagneticTracker> tracker_;
  std::array<wire::FastrakLayout, wire::kFastrakStations> layouts_;
  std::array<bool, wire::kFastrakStations> is_active_{};
  bool is_binary_ = false;
  bool is_continuous_ = false;
  wire::FastrakUnit unit_ = wire::FastrakUnit::inch;
  std::string pending_;  // a command that waits for its CR
  double silent_until_s_ = -1;
};

/// The board of drivers/wire/led_board.h. The length of its tick is the scene's: B is answered with it, whatever was asked.
class LedBoardConsole final : public Console {
 public:
  explicit LedBoardConsole(std::shared_ptr<const LedBoard> board) : board_(std::move(board)) {}

  std::string take(std::string_view received, double time_s) override;
  std::string record(std::uint64_t number, double) override { return board_->record(number); }

 private:
  std::string answer(std::string_view line, double time_s) const;

  std::shared_ptr<const LedBoard> board_;
  std::string pending_;
};

}  // namespace roseau::synthesis
