#include "synthesis/wind/gust_tables.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace roseau::synthesis {

namespace {
constexpr double kFullScaleSds = 10;
constexpr double kFullScaleCounts = 32767;
constexpr std::size_t kOverlap = 4;  // entries of the start repeated at the end: four neighbours never wrap
// Tables of a round size would all begin at the same place in the processor's caches. 40 entries = 5 cache lines on.
constexpr std::size_t kCacheSkew = 40;

double spline_response(double frequency_hz) {
  const double x = std::numbers::pi * frequency_hz / kGustRateHz;
  return std::pow(std::sin(x) / x, 4);
}

bool has_small_factors(std::size_t size) {
  for (const std::size_t factor : {2U, 3U, 5U}) {
    while (size % factor == 0) size /= factor;
  }
  return size == 1;
}
}  // namespace

std::size_t GustTables::size_for(double period_s) {
  // A multiple of four: the fast way of the real transform.
  std::size_t quarter = static_cast<std::size_t>(std::ceil(period_s * kGustRateHz / 4 - 1e-9));
  while (!has_small_factors(quarter)) ++quarter;
  return 4 * quarter;
}

std::size_t GustTables::bytes_per_table(double period_s) { return (size_for(period_s) + kCacheSkew) * sizeof(Entry); }

GustTables::GustTables(std::size_t strands, std::size_t fillers, double period_s, const std::array<double, kComponents>& sd_mps)
    : size_(size_for(period_s)),
      period_s_(static_cast<double>(size_) / kGustRateHz),
      harmonics_(static_cast<std::size_t>(kHighestGustHz * period_s_)),
      starts_{0} {
  static_assert(kCacheSkew > kOverlap);
  for (std::size_t table = 0; table < strands + fillers; ++table) {
    starts_.push_back(starts_.back() + (table < strands ? 1 : 2) * size_ + kCacheSkew);
  }
  entries_.resize(starts_.back());
  for (std::size_t c = 0; c < kComponents; ++c) to_mps_[c] = static_cast<float>(kFullScaleSds * sd_mps[c] / kFullScaleCounts);
  for (std::size_t k = 1; k <= harmonics_; ++k) {
    sharpening_.push_back(static_cast<float>(1 / spline_response(static_cast<double>(k) / period_s_)));
  }
}

void GustTables::make(Component component, std::size_t first, std::span<const std::complex<float>> amplitudes) {
  Eigen::FFT<float> fft;
  fft.SetFlag(Eigen::FFT<float>::HalfSpectrum);
  fft.SetFlag(Eigen::FFT<float>::Unscaled);
  std::vector<std::complex<float>> half_spectrum(size_ / 2 + 1);
  std::vector<float> series(size_);
  const float to_counts = to_mps_[component] > 0 ? 1 / to_mps_[component] : 0;
  for (std::size_t row = 0; row < amplitudes.size() / harmonics_; ++row) {
    const auto amplitude = amplitudes.subspan(row * harmonics_, harmonics_);
    for (std::size_t k = 0; k < harmonics_; ++k) {
      half_spectrum[k + 1] = std::conj(amplitude[k]) * (0.5F * to_counts * sharpening_[k]);
    }
    fft.inv(series.data(), half_spectrum.data(), static_cast<Eigen::Index>(size_));
    const std::size_t start = starts_[first + row];
    const std::size_t filled = starts_[first + row + 1] - start - (kCacheSkew - kOverlap);
    // The coefficient before the time's own comes first in a place, so the table starts with the last one.
    for (std::size_t i = 0; i < filled; ++i) {
      const float counts = std::clamp(series[(i + size_ - 1) % size_], -32767.0F, 32767.0F);
      entries_[start + i].counts[component] = static_cast<std::int16_t>(std::lrint(counts));
    }
  }
}

}  // namespace roseau::synthesis
