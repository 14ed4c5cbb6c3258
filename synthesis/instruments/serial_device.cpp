#include "synthesis/instruments/serial_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/check.h"

namespace roseau::synthesis {

namespace {
constexpr double kBitsPerByte = 10;     // 8N1
constexpr double kEndOfTime_s = 1e8;    // three years: no scene is that long
constexpr double kConnectMargin_s = 2;  // longer than any record is on its way
constexpr std::uint64_t kMostBytesPerRecord = 1024;
}  // namespace

Duration byte_time(const SerialLineOptions& line) { return from_seconds(kBitsPerByte / line.baud); }

void LineNoise::apply(std::uint64_t record_number, std::string& bytes) const {
  if (probability_ <= 0) return;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const std::uint64_t index = 2 * (record_number * kMostBytesPerRecord + i);
    if (random_.uniform(index) >= probability_) continue;
    bytes[i] = static_cast<char>(static_cast<unsigned char>(bytes[i]) ^ (1U << (random_.bits(index + 1) % 8)));
  }
}

SerialDevice::SerialDevice(std::shared_ptr<const SerialInstrument> instrument, std::uint64_t seed, std::uint64_t stream)
    : instrument_(std::move(instrument)),
      splits_(seed, stream),
      noise_(instrument_->line().byte_error_probability, seed, stream + 1),
      byte_time_(byte_time(instrument_->line())) {
  fill();
}

void SerialDevice::declare(StreamTable& streams) { stream_ = streams.add(instrument_->raw_stream("simulated")); }

Due SerialDevice::next() const {
  if (on_line_.empty()) return Due::never();
  return {on_line_.front().arrival, complete(on_line_.front())};
}

void SerialDevice::fill() {
  const SampleTimes& times = instrument_->times();
  while (on_line_.empty()) {
    const double time_s = times.sample_time_s(record_);
    if (time_s > kEndOfTime_s) return;
    send_record();
    if (!on_line_.empty()) return;
    // A cable may be out for long: what is surely lost need not be measured.
    const double until_s = times.pulled_until_s(time_s);
    if (until_s > kEndOfTime_s) return;
    if (until_s > time_s + kConnectMargin_s) record_ = std::max(record_, times.first_from(until_s - kConnectMargin_s));
  }
}

void SerialDevice::send_record() {
  const std::uint64_t number = record_++;
  const SampleTimes& times = instrument_->times();
  if (times.is_dropped(number)) return;
  const SerialLineOptions& line = instrument_->line();
  const Duration ready = from_seconds(times.sample_time_s(number) + times.delay_s(number));
  if (line.discards_when_busy && ready < line_free_) return;
  std::string record = instrument_->record(number);
  ROSEAU_CHECK(record.size() <= kMostBytesPerRecord);
  if (record.empty()) return;
  noise_.apply(number, record);
  const Duration begin = std::max(ready, line_free_);
  const std::span<const char> all(record);
  std::size_t cut = all.size();
  if (all.size() > 1 && splits_.uniform(2 * number) < line.split_probability) {
    cut = 1 + splits_.bits(2 * number + 1) % (all.size() - 1);
  }
  send_piece(all.first(cut), begin);
  send_piece(all.subspan(cut), begin + byte_time_ * static_cast<Duration::rep>(cut));
  line_free_ = begin + byte_time_ * static_cast<Duration::rep>(all.size());
}

// Bytes that were on the line while the cable was out are lost: a record may come cut off.
void SerialDevice::send_piece(std::span<const char> bytes, Duration arrival) {
  const SampleTimes& times = instrument_->times();
  while (!bytes.empty()) {
    Piece piece{.arrival = arrival};
    std::size_t used = 0;
    for (; used < bytes.size() && piece.bytes.size < RawBytes::kCapacity; ++used) {
      const Duration time = arrival + byte_time_ * static_cast<Duration::rep>(used);
      if (times.is_pulled(to_seconds(time))) break;
      piece.bytes.storage.at(piece.bytes.size++) = static_cast<std::byte>(bytes[used]);
    }
    piece.bytes.byte_time = byte_time_;
    if (piece.bytes.size > 0) on_line_.push_back(piece);
    // At least one byte further: the one that fell into a pull.
    used = std::max<std::size_t>(used, 1);
    bytes = bytes.subspan(used);
    arrival += byte_time_ * static_cast<Duration::rep>(used);
  }
}

bool SerialDevice::produce(HostTime start, SampleSink& sink) {
  if (on_line_.empty()) return true;
  const Piece piece = on_line_.front();
  on_line_.pop_front();
  fill();
  const HostTime arrival = start + piece.arrival;
  sink.receive({{.stream = stream_,
                 .sequence = static_cast<std::uint32_t>(pieces_handed_on_++),
                 .arrival_time = arrival,
                 .sample_time = arrival},
                piece.bytes});
  return true;
}

void SerialDevice::connect_at(Duration time) {
  const std::uint64_t first = instrument_->times().first_from(to_seconds(time) - kConnectMargin_s);
  if (first > record_) {
    on_line_.clear();
    record_ = first;
  }
  fill();
  while (!on_line_.empty() && on_line_.front().arrival < time) {
    on_line_.pop_front();
    fill();
  }
}

std::optional<Error> SerialDevice::fault_at(Duration time) const {
  if (!instrument_->times().is_pulled(to_seconds(time))) return std::nullopt;
  return Error{ErrorCode::disconnected, fmt::format("{}: the serial port is gone: plug its cable in again", name())};
}

}  // namespace roseau::synthesis
