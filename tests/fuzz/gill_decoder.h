// What both Gill fuzzers do: any bytes, cut two ways, must give the same samples and counters, and every sample must come out
// of an encoder and decoder again as it went in.
#pragma once

#include <cmath>
#include <string_view>
#include <vector>

#include "core/check.h"
#include "drivers/wire/gill_decoder.h"
#include "tests/fuzz/feed.h"

namespace roseau::fuzz {

inline bool same_number(double a, double b, double tolerance) {
  return (std::isnan(a) && std::isnan(b)) || std::abs(a - b) <= tolerance;
}

/// `encode` prints a sample in components with two decimals.
template <class Encode>
void check_gill_decoder(wire::GillDialect dialect, bool keeps_messages_apart, std::string_view text, const Encode& encode) {
  // A message must stay in one piece, so there only one way of cutting is tried.
  const wire::GillDecoder::Options options{.keeps_messages_apart = keeps_messages_apart, .dialect = dialect};
  wire::GillDecoder whole(options);
  Collector from_whole;
  if (keeps_messages_apart) {
    feed(whole, text, RawBytes::kCapacity, from_whole);
  } else {
    wire::GillDecoder cut(options);
    from_whole.samples = check_cuts(whole, cut, text);
  }
  for (const auto& sample : from_whole.samples) {
    const auto& sent = std::get<WindSample>(sample.payload);
    if (std::hypot(sent.u_mps, sent.v_mps) > 99.9) continue;  // rounding may carry it over the limit
    const std::vector<std::byte> bytes = encode(sent);
    wire::GillDecoder again(options);
    Collector echo;
    feed(again, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}, RawBytes::kCapacity, echo);
    ROSEAU_CHECK(echo.samples.size() == 1);
    const auto& got = std::get<WindSample>(echo.samples[0].payload);
    ROSEAU_CHECK(got.valid == sent.valid && got.device_status == sent.device_status);
    ROSEAU_CHECK(same_number(got.u_mps, sent.u_mps, 0.006) && same_number(got.v_mps, sent.v_mps, 0.006));
  }
}

}  // namespace roseau::fuzz
