// An LED synchronisation board in the simulated field: its clock, which the renderer lights the LEDs by, and its serial line.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "drivers/wire/led_board.h"
#include "synthesis/instruments/device_timing.h"
#include "synthesis/instruments/serial_device.h"

namespace roseau::synthesis {

struct LedBoardOptions {
  double tick_s = 0.0005;
  double baud = 115200;             // 8N1; a USB serial port in truth
  double split_probability = 0.05;  // that a line arrives in two pieces
  double byte_error_probability = 0;
  DeviceTiming timing{.frequency_offset_ppm = 12, .latency_s = 0.0012, .jitter_s = 0.0002, .counter_offset_s = 60};
};

class LedBoard final : public SerialInstrument {
 public:
  LedBoard(std::string name, const LedBoardOptions& options, std::uint64_t seed);

  const std::string& name() const override { return name_; }
  StreamInfo raw_stream(const std::string& link) const override;
  /// Of its messages: one every 256 ticks, at a latch.
  const SampleTimes& times() const override { return times_; }
  const SerialLineOptions& line() const override { return line_; }
  std::string record(std::uint64_t number) const override;

  /// The board's counter at a time of the scene, in ticks with their fraction. Its LEDs show the whole number. Wraps at 2^32
  /// only on the wire.
  double ticks_at(double time_s) const { return times_.clock().device_time_s(time_s) / options_.tick_s; }

  /// The board's microseconds at a time of the scene, as it answers them.
  std::uint64_t microseconds_at(double time_s) const;

  double tick_s() const { return options_.tick_s; }
  const SimulatedClock& clock() const { return times_.clock(); }

 private:
  std::string name_;
  LedBoardOptions options_;
  std::uint64_t first_message_;  // messages that the board sent before the scene began
  SampleTimes times_;
  SerialLineOptions line_;
};

/// Plays it. Stream: /<name>/raw.
std::unique_ptr<SimulatedDevice> make_led_board_device(std::shared_ptr<const LedBoard> board, std::uint64_t seed);

}  // namespace roseau::synthesis
