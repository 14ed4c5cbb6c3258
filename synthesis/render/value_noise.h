// Smooth random patterns over a plane.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/random.h"

namespace roseau::render {

inline double smooth_step(double low, double high, double value) {
  const double s = std::clamp((value - low) / (high - low), 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

/// 0..1: random values on a unit lattice, interpolated with continuous slope. With a period, the pattern repeats in x.
class ValueNoise {
 public:
  ValueNoise(std::uint64_t seed, std::uint64_t stream, std::int64_t period = 0) : random_(seed, stream), period_(period) {}

  double at(double x, double y) const { return at(x, y, period_); }

  /// Sum of octaves, each twice as fine and `roughness` times as strong; 0..1, mean 0.5.
  double octaves(double x, double y, int count, double roughness = 0.5) const {
    double sum = 0;
    double weight = 1;
    double weights = 0;
    std::int64_t period = period_;
    for (int octave = 0; octave < count; ++octave) {
      sum += weight * at(x, y, period);
      weights += weight;
      weight *= roughness;
      x = 2 * x + 17.3;
      y = 2 * y + 5.9;
      period *= 2;
    }
    return sum / weights;
  }

 private:
  double at(double x, double y, std::int64_t period) const {
    const double x0 = std::floor(x);
    const double y0 = std::floor(y);
    const double sx = ease(x - x0);
    const double sy = ease(y - y0);
    const auto i = static_cast<std::int64_t>(x0);
    const auto j = static_cast<std::int64_t>(y0);
    const double low = lattice(i, j, period) + sx * (lattice(i + 1, j, period) - lattice(i, j, period));
    const double high = lattice(i, j + 1, period) + sx * (lattice(i + 1, j + 1, period) - lattice(i, j + 1, period));
    return low + sy * (high - low);
  }
  static double ease(double s) { return s * s * (3 - 2 * s); }
  double lattice(std::int64_t i, std::int64_t j, std::int64_t period) const {
    if (period > 0) i = ((i % period) + period) % period;
    return random_.uniform((static_cast<std::uint64_t>(i) << 32U) ^ (static_cast<std::uint64_t>(j) & 0xFFFFFFFFU));
  }

  RandomStream random_;
  std::int64_t period_;
};

}  // namespace roseau::render
