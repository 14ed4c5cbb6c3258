#include "synthesis/instruments/led_board.h"

#include <cmath>
#include <utility>

namespace roseau::synthesis {

namespace {

constexpr std::uint64_t kTimingStream = 2200;
constexpr std::uint64_t kLineStream = 2202;

double message_interval_s(const LedBoardOptions& options) { return options.tick_s * wire::kLedBoardTicksPerMessage; }

// Messages are sent at whole multiples of their interval on the board's counter: the first one is the first of them at or
// after the board's start.
std::uint64_t first_message(const LedBoardOptions& options) {
  return static_cast<std::uint64_t>(std::ceil(options.timing.counter_offset_s / message_interval_s(options) - 1e-9));
}

DeviceTiming from_first_message(const LedBoardOptions& options, std::uint64_t seed) {
  DeviceTiming timing = options.timing;
  const double counter_s = static_cast<double>(first_message(options)) * message_interval_s(options);
  timing.start_offset_s = SimulatedClock(options.timing, seed, kTimingStream).time_of_s(counter_s);
  timing.counter_offset_s = counter_s;
  return timing;
}

}  // namespace

LedBoard::LedBoard(std::string name, const LedBoardOptions& options, std::uint64_t seed)
    : name_(std::move(name)),
      options_(options),
      first_message_(first_message(options)),
      times_(1 / message_interval_s(options), from_first_message(options, seed), seed, kTimingStream),
      line_{.baud = options.baud,
            .split_probability = options.split_probability,
            .byte_error_probability = options.byte_error_probability} {}

StreamInfo LedBoard::raw_stream(const std::string& link) const {
  return wire::raw_stream(
      name_, wire::LedBoardOptions{.tick_us = static_cast<std::uint32_t>(std::lround(options_.tick_s * 1e6))}, link);
}

std::uint64_t LedBoard::microseconds_at(double time_s) const {
  return static_cast<std::uint64_t>(std::max(0.0, std::floor(times_.clock().device_time_s(time_s) * 1e6)));
}

std::string LedBoard::record(std::uint64_t number) const {
  const std::uint64_t message = first_message_ + number;
  return wire::encode_led_board({.kind = wire::LedBoardMessage::Kind::latch,
                                 .tick = static_cast<std::uint32_t>(message * wire::kLedBoardTicksPerMessage),
                                 .sequence = static_cast<std::uint32_t>(message)});
}

std::unique_ptr<SimulatedDevice> make_led_board_device(std::shared_ptr<const LedBoard> board, std::uint64_t seed) {
  return std::make_unique<SerialDevice>(std::move(board), seed, kLineStream);
}

}  // namespace roseau::synthesis
