// SensorNoise: shot and read noise of a camera. The noise of a frame is a function of (seed, frame number): frames can be made
// in any order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "synthesis/random.h"

namespace roseau::synthesis {

struct SensorNoiseOptions {
  double read_noise_counts = 1;   // standard deviation
  double shot_noise_gain = 0.02;  // variance per count of signal
};

class SensorNoise {
 public:
  /// Rows of at most `row_bytes`.
  SensorNoise(const SensorNoiseOptions& options, std::uint64_t seed, std::size_t row_bytes);

  /// Adds noise to a row of 8-bit values: `noisy` = `clean` + noise, rounded and clipped. Both of the same size.
  void apply(std::span<const std::uint8_t> clean, std::uint64_t frame, std::uint32_t row, std::span<std::uint8_t> noisy) const;

 private:
  RandomStream offsets_;
  // Gaussian numbers, kUnit to one standard deviation. Each row of each frame starts at a random place of the table: far
  // cheaper than a number per pixel, and no two frames are alike.
  std::vector<std::int8_t> gauss_;
  std::array<std::int16_t, 256> sd_by_signal_{};  // in 1 / kUnit counts
  bool silent_ = false;
};

}  // namespace roseau::synthesis
