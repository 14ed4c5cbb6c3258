#include "replay/emulator.h"

#include <algorithm>
#include <array>
#include <span>
#include <thread>
#include <utility>

namespace roseau::replay {

namespace {

using std::chrono::milliseconds;

// Whoever listens may hang up or stop reading at any time; an instrument does not mind.
Result<void> forgiving(const Result<void>& result) {
  if (result || result.error().code == ErrorCode::disconnected || result.error().code == ErrorCode::timeout) return {};
  return result.error();
}

}  // namespace

Emulator::Emulator(std::unique_ptr<link::ByteStream> stream, std::unique_ptr<EmulatedInstrument> instrument, HostTime start,
                   Clock now)
    : stream_(std::move(stream)), instrument_(std::move(instrument)), start_(start), now_(std::move(now)) {}

Result<void> Emulator::open() {
  auto opened = stream_->open();
  is_open_ = opened.has_value();
  return opened;
}

Result<void> Emulator::step(milliseconds timeout) {
  const Duration now = since_start();
  if (auto followed = follow_cable(now); !followed) return followed;
  const Duration left = std::clamp<Duration>(instrument_->next() - now, Duration{0}, timeout);
  if (!is_open_) {
    std::this_thread::sleep_for(left);
    return send_due();
  }
  if (auto answered = answer(std::chrono::duration_cast<milliseconds>(left)); !answered) return answered;
  // Links wait in whole milliseconds; the rest of one is waited out here.
  const Duration rest = instrument_->next() - since_start();
  if (rest > Duration{0} && rest < milliseconds(1)) std::this_thread::sleep_for(rest);
  return send_due();
}

Result<void> Emulator::follow_cable(Duration now) {
  const bool should_be_open = instrument_->is_connected(now);
  if (should_be_open && !is_open_) return open();
  if (!should_be_open && is_open_) {
    stream_->close();
    is_open_ = false;
  }
  return {};
}

Result<void> Emulator::answer(milliseconds timeout) {
  std::array<std::byte, 1024> buffer{};
  const auto received = stream_->read(buffer, timeout);
  if (!received) return forgiving(Result<void>(received.error()));
  if (received->size == 0) return {};
  counters_.bytes_received += received->size;
  const std::string_view text(reinterpret_cast<const char*>(buffer.data()), received->size);
  return write(instrument_->answer(text, since_start()));
}

Result<void> Emulator::send_due() {
  while (instrument_->next() <= since_start()) {
    const std::string bytes = instrument_->send(since_start());
    if (bytes.empty() || !is_open_) continue;
    ++counters_.records_sent;
    if (auto written = write(bytes); !written) return written;
  }
  return {};
}

Result<void> Emulator::write(const std::string& bytes) {
  if (bytes.empty()) return {};
  counters_.bytes_sent += bytes.size();
  return forgiving(stream_->write(std::as_bytes(std::span(bytes))));
}

}  // namespace roseau::replay
