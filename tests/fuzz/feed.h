// Any bytes to any decoder, cut in two ways, which must give the same.
#pragma once

#include <algorithm>
#include <string_view>
#include <vector>

#include "core/check.h"
#include "core/decoder.h"

namespace roseau::fuzz {

struct Collector : SampleSink {
  bool receive(Sample sample) override {
    samples.push_back(std::move(sample));
    return true;
  }
  std::vector<Sample> samples;
};

inline void feed(Decoder& decoder, std::string_view text, std::size_t piece_size, SampleSink& sink) {
  for (std::size_t begin = 0; begin < text.size(); begin += piece_size) {
    const auto piece = text.substr(begin, piece_size);
    RawBytes raw;
    raw.size = static_cast<std::uint16_t>(piece.size());
    raw.byte_time = Duration{1000};
    std::ranges::transform(piece, raw.storage.begin(), [](char c) { return static_cast<std::byte>(c); });
    Sample sample;
    sample.header.arrival_time = HostTime{raw.byte_time * static_cast<Duration::rep>(begin)};
    sample.payload = raw;
    decoder.decode(sample, sink);
  }
}

/// Two decoders of one kind: one gets long pieces, the other single bytes. What they made of it.
inline std::vector<Sample> check_cuts(Decoder& whole, Decoder& cut, std::string_view text) {
  Collector from_whole;
  Collector from_cut;
  feed(whole, text, RawBytes::kCapacity, from_whole);
  feed(cut, text, 1, from_cut);
  ROSEAU_CHECK(from_cut.samples.size() == from_whole.samples.size());
  ROSEAU_CHECK(cut.counters().bad_records == whole.counters().bad_records);
  ROSEAU_CHECK(cut.counters().skipped_bytes == whole.counters().skipped_bytes);
  for (std::size_t i = 0; i < from_whole.samples.size(); ++i) {
    ROSEAU_CHECK(from_cut.samples[i].header.arrival_time == from_whole.samples[i].header.arrival_time);
    ROSEAU_CHECK(from_cut.samples[i].header.device_time == from_whole.samples[i].header.device_time);
  }
  return from_whole.samples;
}

}  // namespace roseau::fuzz
