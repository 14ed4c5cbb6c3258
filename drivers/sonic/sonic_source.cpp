#include "drivers/sonic/sonic_source.h"

#include <algorithm>
#include <span>
#include <utility>

namespace roseau::sonic {

SonicSource::SonicSource(SonicOptions options, std::unique_ptr<link::ByteStream> stream)
    : options_(std::move(options)), stream_(std::move(stream)) {
  options_.anemometer.keeps_messages_apart = stream_->keeps_messages_apart();
}

Result<void> SonicSource::open(StreamTable& streams) {
  if (auto opened = stream_->open(); !opened) return opened;
  const StreamInfo raw = wire::raw_stream(options_.name, options_.anemometer, stream_->description());
  raw_stream_ = streams.add(raw);
  streams.add(wire::wind_stream(raw));
  return {};
}

Result<ReadStatus> SonicSource::read(SampleSink& sink, std::chrono::milliseconds timeout) {
  const auto received = stream_->read(buffer_, timeout);
  if (!received) return received.error();
  if (received->finished) return ReadStatus::finished;
  if (received->size == 0) return ReadStatus::idle;
  hand_on(*received, sink);
  return ReadStatus::more;
}

void SonicSource::hand_on(const link::Received& received, SampleSink& sink) {
  auto rest = std::span<const std::byte>(buffer_).first(received.size);
  HostTime first_byte_time = received.first_byte_time;
  std::uint16_t line_errors = received.line_errors;
  while (!rest.empty()) {
    const auto piece = rest.first(std::min(rest.size(), RawBytes::kCapacity));
    Sample sample;
    sample.header.stream = raw_stream_;
    sample.header.sequence = sequence_++;
    sample.header.arrival_time = first_byte_time;
    sample.header.sample_time = first_byte_time;
    auto& raw = sample.payload.emplace<RawBytes>();
    std::ranges::copy(piece, raw.storage.begin());
    raw.size = static_cast<std::uint16_t>(piece.size());
    raw.byte_time = stream_->byte_time();
    raw.line_errors = std::exchange(line_errors, std::uint16_t{0});
    // A full sink counts the drop itself.
    sink.receive(std::move(sample));
    first_byte_time += stream_->byte_time() * static_cast<Duration::rep>(piece.size());
    rest = rest.subspan(piece.size());
  }
}

}  // namespace roseau::sonic
