// Feeding bytes to any decoder and collecting its samples.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/decoder.h"
#include "core/sample.h"

namespace roseau::wire {

inline constexpr Duration kByteTime{1'000'000};
inline constexpr HostTime kFirstArrival{Duration{1'000'000'000}};

template <class DecoderType>
class FedDecoder : public SampleSink {
 public:
  explicit FedDecoder(typename DecoderType::Options options) : decoder_(std::move(options)) {}

  /// One read; its bytes follow those before on the wire without a pause.
  void feed(std::string_view text) {
    while (!text.empty()) {
      const auto piece = text.substr(0, RawBytes::kCapacity);
      Sample sample;
      sample.header.arrival_time = kFirstArrival + kByteTime * static_cast<Duration::rep>(fed_);
      RawBytes raw;
      raw.size = static_cast<std::uint16_t>(piece.size());
      raw.byte_time = kByteTime;
      std::ranges::transform(piece, raw.storage.begin(), [](char c) { return static_cast<std::byte>(c); });
      sample.payload = raw;
      decoder_.decode(sample, *this);
      fed_ += piece.size();
      text.remove_prefix(piece.size());
    }
  }
  void feed_in_pieces(std::string_view text, std::size_t size) {
    for (; !text.empty(); text.remove_prefix(std::min(size, text.size()))) feed(text.substr(0, size));
  }

  bool receive(Sample sample) override {
    samples_.push_back(std::move(sample));
    return true;
  }

  const std::vector<Sample>& samples() const { return samples_; }
  const DecoderCounters& counters() const { return decoder_.counters(); }
  DecoderType& decoder() { return decoder_; }

 private:
  DecoderType decoder_;
  std::vector<Sample> samples_;
  std::size_t fed_ = 0;
};

inline std::string describe(const DecoderCounters& counters) {
  return "good " + std::to_string(counters.records) + " bad " + std::to_string(counters.bad_records) + " skipped " +
         std::to_string(counters.skipped_bytes) + " text " + std::to_string(counters.text_lines);
}

}  // namespace roseau::wire
