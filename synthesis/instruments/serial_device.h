// An instrument on a serial line: records in, pieces of bytes out, as a host's reads would find them.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <string>

#include "core/stream.h"
#include "synthesis/instruments/device_timing.h"
#include "synthesis/instruments/simulated_device.h"

namespace roseau::synthesis {

/// The line between an instrument and the host, 8N1.
struct SerialLineOptions {
  double baud = 38400;
  double split_probability = 0;       // that a record arrives in two pieces
  double byte_error_probability = 0;  // that one bit of a byte is turned over on its way
  bool discards_when_busy = false;    // a record that the line has no time for is lost; else it waits
};

/// Time one byte takes.
Duration byte_time(const SerialLineOptions& line);

/// Turns bits over, by the record's number: the same ones every time.
class LineNoise {
 public:
  LineNoise(double byte_error_probability, std::uint64_t seed, std::uint64_t stream)
      : probability_(byte_error_probability), random_(seed, stream) {}
  void apply(std::uint64_t record_number, std::string& bytes) const;

 private:
  double probability_;
  RandomStream random_;
};

/// Pure: every record is a function of its number. Safe to call from several threads.
class SerialInstrument {
 public:
  virtual ~SerialInstrument() = default;
  virtual const std::string& name() const = 0;
  /// Its raw stream; `link` is for people.
  virtual StreamInfo raw_stream(const std::string& link) const = 0;
  /// Record `number` is measured at its sample time, and its first byte leaves after its delay.
  virtual const SampleTimes& times() const = 0;
  virtual const SerialLineOptions& line() const = 0;
  virtual std::string record(std::uint64_t number) const = 0;
};

/// Plays an instrument. Stream: /<name>/raw.
class SerialDevice final : public SimulatedDevice {
 public:
  /// `stream`: of the line's random numbers, and the one behind it.
  SerialDevice(std::shared_ptr<const SerialInstrument> instrument, std::uint64_t seed, std::uint64_t stream);

  const std::string& name() const override { return instrument_->name(); }
  void declare(StreamTable& streams) override;
  Due next() const override;
  bool produce(HostTime start, SampleSink& sink) override;
  /// A serial port's buffer outlasts any stall that we survive: nothing is lost.
  void lose_before(Duration) override {}
  void lose_next() override {}
  /// Nobody listened before: those bytes are gone.
  void connect_at(Duration time) override;
  std::optional<Error> fault_at(Duration time) const override;

 private:
  struct Piece {
    Duration arrival{0};
    RawBytes bytes;
  };

  Duration complete(const Piece& piece) const { return piece.arrival + byte_time_ * piece.bytes.size; }
  void fill();
  void send_record();
  void send_piece(std::span<const char> bytes, Duration arrival);

  std::shared_ptr<const SerialInstrument> instrument_;
  RandomStream splits_;
  LineNoise noise_;
  Duration byte_time_;

  StreamId stream_ = 0;
  std::uint64_t record_ = 0;
  std::uint64_t pieces_handed_on_ = 0;
  Duration line_free_{0};      // when the last byte sent is through
  std::deque<Piece> on_line_;  // empty only when nothing will ever come
};

}  // namespace roseau::synthesis
