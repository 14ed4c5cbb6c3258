// Feeding bytes to a decoder and collecting its samples.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/sample.h"
#include "drivers/wire/fields.h"
#include "drivers/wire/gill_decoder.h"

namespace roseau::wire {

inline constexpr Duration kByteTime{1'000'000};
inline constexpr HostTime kFirstArrival{Duration{1'000'000'000}};

class DecoderUnderTest : public SampleSink {
 public:
  explicit DecoderUnderTest(GillDecoder::Options options) : decoder_(options) {}
  explicit DecoderUnderTest(GillDialect dialect) : DecoderUnderTest(GillDecoder::Options{.stream = 7, .dialect = dialect}) {}

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
  const WindSample& wind(std::size_t index) const { return std::get<WindSample>(samples_.at(index).payload); }
  const DecoderCounters& counters() const { return decoder_.counters(); }
  GillDecoder& decoder() { return decoder_; }

 private:
  GillDecoder decoder_;
  std::vector<Sample> samples_;
  std::size_t fed_ = 0;
};

inline std::string framed(std::string_view body, std::string_view checksum) {
  return "\x02" + std::string(body) + "\x03" + std::string(checksum) + "\r\n";
}
inline std::string framed(std::string_view body) { return framed(body, hex_byte(xor_of(body))); }

inline std::string text_of(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// What a decoder made of a stream: to compare one way of cutting it into reads with another.
inline std::string digest_of(const DecoderUnderTest& decoder) {
  std::string digest;
  for (const auto& sample : decoder.samples()) {
    const auto& wind = std::get<WindSample>(sample.payload);
    digest += std::to_string(to_ns(sample.header.arrival_time)) + " " + std::to_string(wind.u_mps) + " " +
              std::to_string(wind.v_mps) + " " + std::to_string(wind.w_mps) + " " + std::to_string(wind.device_status) + "\n";
  }
  const auto& counters = decoder.counters();
  return digest + "good " + std::to_string(counters.records) + " bad " + std::to_string(counters.bad_records) + " skipped " +
         std::to_string(counters.skipped_bytes) + " text " + std::to_string(counters.text_lines);
}

}  // namespace roseau::wire
