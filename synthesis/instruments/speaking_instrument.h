// An instrument of the simulated field that can be spoken to: for emulators on ttys and sockets (core/emulated_instrument.h).
#pragma once

#include <memory>
#include <string>

#include "core/emulated_instrument.h"
#include "synthesis/instruments/console.h"
#include "synthesis/instruments/serial_device.h"
#include "synthesis/instruments/sonic.h"

namespace roseau::synthesis {

class SpeakingInstrument final : public EmulatedInstrument {
 public:
  /// `seed` is the scene's: of the errors on the line.
  SpeakingInstrument(std::shared_ptr<const SerialInstrument> instrument, std::unique_ptr<Console> console, std::uint64_t seed);

  const std::string& name() const override { return instrument_->name(); }
  Duration next() const override { return next_; }
  std::string send(Duration now) override;
  std::string answer(std::string_view received, Duration now) override;
  bool is_connected(Duration now) const override;

 private:
  Duration begin_of(std::uint64_t number) const;
  void go_to(std::uint64_t number);

  std::shared_ptr<const SerialInstrument> instrument_;
  std::unique_ptr<Console> console_;
  LineNoise noise_;
  Duration byte_time_;
  std::uint64_t number_ = 0;   // of the record that comes next
  std::size_t last_size_ = 0;  // of the last record: the next one will be as long
  Duration line_free_{0};
  Duration next_{0};
};

std::unique_ptr<EmulatedInstrument> make_speaking(std::shared_ptr<const Sonic> sonic, std::uint64_t seed);
std::unique_ptr<EmulatedInstrument> make_speaking(std::shared_ptr<const MagneticTracker> tracker, std::uint64_t seed);
std::unique_ptr<EmulatedInstrument> make_speaking(std::shared_ptr<const LedBoard> board, std::uint64_t seed);

}  // namespace roseau::synthesis
