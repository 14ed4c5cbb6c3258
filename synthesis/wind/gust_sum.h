// The innermost loop of the wind: weighted sums of gust tables, for several places at once. Vector code that chooses the
// CPU's widest form at run time; all forms add in the same order and give the same bits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "synthesis/wind/gust_tables.h"

namespace roseau::synthesis {

/// What makes the gust at one place: parts of four strands and five fillers, all at one time.
struct GustReading {
  static constexpr std::size_t kTerms = 9;

  const GustTables::Entry* entries = nullptr;  // of the first table, at the time
  const std::uint32_t* starts = nullptr;       // kTerms of them: where each term's table stands after the first
  std::array<float, kTerms> shares;            // of each term
  std::array<float, 4> weights;                // of the four entries from there on
};

/// Cubic B-spline's weights of four neighbouring coefficients, `share` of the way from the second to the third.
inline std::array<float, 4> cubic_weights(float share) {
  const float s = share;
  const float r = 1 - s;
  constexpr float kSixth = 1.0F / 6;
  return {r * r * r * kSixth, (s * s * (3 * s - 6) + 4) * kSixth, (r * r * (3 * r - 6) + 4) * kSixth, s * s * s * kSixth};
}

/// In counts, one element per reading.
void sum_gusts(std::span<const GustReading> readings, std::span<std::array<float, 4>> sums);

}  // namespace roseau::synthesis
