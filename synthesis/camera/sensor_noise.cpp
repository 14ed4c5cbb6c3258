#include "synthesis/camera/sensor_noise.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/check.h"

namespace roseau::synthesis {

namespace {
constexpr std::size_t kTableSize = 1 << 16U;
constexpr int kUnit = 32;  // 127 / 32: numbers beyond 4 standard deviations are clipped there
constexpr std::uint64_t kTableStream = 301;
constexpr std::uint64_t kOffsetStream = 302;
}  // namespace

SensorNoise::SensorNoise(const SensorNoiseOptions& options, std::uint64_t seed, std::size_t row_bytes)
    : offsets_(seed, kOffsetStream), gauss_(kTableSize + row_bytes) {
  const RandomStream normals(seed, kTableStream);
  for (std::size_t i = 0; i < gauss_.size(); ++i) {
    gauss_[i] = static_cast<std::int8_t>(std::clamp<long>(std::lround(kUnit * normals.normal(i)), -127, 127));
  }
  for (std::size_t signal = 0; signal < sd_by_signal_.size(); ++signal) {
    const double variance =
        options.read_noise_counts * options.read_noise_counts + options.shot_noise_gain * static_cast<double>(signal);
    sd_by_signal_.at(signal) = static_cast<std::int16_t>(std::lround(kUnit * std::sqrt(variance)));
  }
  silent_ = std::ranges::all_of(sd_by_signal_, [](int sd) { return sd == 0; });
}

void SensorNoise::apply(std::span<const std::uint8_t> clean, std::uint64_t frame, std::uint32_t row,
                        std::span<std::uint8_t> noisy) const {
  ROSEAU_CHECK(clean.size() == noisy.size() && clean.size() + kTableSize <= gauss_.size());
  if (silent_) {
    std::memcpy(noisy.data(), clean.data(), clean.size());
    return;
  }
  const std::int8_t* gauss = gauss_.data() + offsets_.bits((frame << 16U) + row) % kTableSize;
  constexpr int kRound = kUnit * kUnit / 2;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    const int signal = clean[i];
    const int value = signal + ((gauss[i] * sd_by_signal_[static_cast<std::size_t>(signal)] + kRound) >> 10);
    noisy[i] = static_cast<std::uint8_t>(std::clamp(value, 0, 255));
  }
}

}  // namespace roseau::synthesis
