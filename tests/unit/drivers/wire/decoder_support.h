// Feeding bytes to a Gill decoder and collecting its samples.
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
#include "tests/unit/drivers/wire/fed_decoder.h"

namespace roseau::wire {

class DecoderUnderTest : public FedDecoder<GillDecoder> {
 public:
  using FedDecoder::FedDecoder;
  explicit DecoderUnderTest(GillDialect dialect) : FedDecoder(GillDecoder::Options{.stream = 7, .dialect = dialect}) {}

  const WindSample& wind(std::size_t index) const { return std::get<WindSample>(samples().at(index).payload); }
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
  return digest + describe(decoder.counters());
}

}  // namespace roseau::wire
