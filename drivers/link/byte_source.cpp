#include "drivers/link/byte_source.h"

#include <algorithm>
#include <utility>

namespace roseau::link {

ByteSource::ByteSource(std::string name, std::unique_ptr<ByteStream> stream)
    : name_(std::move(name)), stream_(std::move(stream)) {}

Result<void> ByteSource::open(StreamTable& streams) {
  if (auto opened = stream_->open(); !opened) return opened;
  raw_stream_ = declare(streams);
  return connected();
}

Result<ReadStatus> ByteSource::read(SampleSink& sink, std::chrono::milliseconds timeout) {
  const auto received = stream_->read(buffer_, timeout);
  if (!received) return received.error();
  if (received->finished) return ReadStatus::finished;
  if (received->size > 0) hand_on(*received, sink);
  if (auto talked = talk(std::span<const std::byte>(buffer_).first(received->size)); !talked) return talked.error();
  return received->size == 0 ? ReadStatus::idle : ReadStatus::more;
}

void ByteSource::hand_on(const Received& received, SampleSink& sink) {
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

}  // namespace roseau::link
