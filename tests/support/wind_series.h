// Series of a wind at fixed points over whole periods, and their spectral lines: no leakage, so that nothing needs windows.
#pragma once

#include <cmath>
#include <complex>
#include <span>
#include <unsupported/Eigen/FFT>
#include <vector>

#include "core/wind_field.h"

namespace roseau::synthesis {

/// Along east (x), north (y) and up (z) of one point: for a wind from the west that is along, across (left of it) and up.
struct Series {
  std::vector<double> along, across, up;
};

inline std::vector<Series> series_at(const WindField& wind, std::span<const Vec3> points, double period_s, double rate_hz) {
  std::vector<Series> series(points.size());
  std::vector<Vec3> velocities(points.size());
  for (double i = 0; i < std::round(period_s * rate_hz); ++i) {
    wind.velocities_mps(points, i / rate_hz, velocities);
    for (std::size_t p = 0; p < points.size(); ++p) {
      series[p].along.push_back(velocities[p].x);
      series[p].across.push_back(velocities[p].y);
      series[p].up.push_back(velocities[p].z);
    }
  }
  return series;
}

/// Complex amplitude of each harmonic, so that 2 |line|^2 is its power.
inline std::vector<std::complex<double>> lines_of(const std::vector<double>& series) {
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> lines;
  fft.fwd(lines, series);
  for (auto& line : lines) line /= static_cast<double>(series.size());
  return lines;
}

inline double variance_of(const std::vector<double>& series) {
  double sum = 0;
  double sum2 = 0;
  for (const double value : series) {
    sum += value;
    sum2 += value * value;
  }
  const auto n = static_cast<double>(series.size());
  return sum2 / n - sum * sum / (n * n);
}

/// Root coherence (real part) in [low, high) of pairs of lines that all have the same target: their mean.
struct CoherenceMean {
  double cross = 0;
  double power_a = 0;
  double power_b = 0;

  void add(std::span<const std::complex<double>> a, std::span<const std::complex<double>> b, std::size_t first,
           std::size_t end) {
    for (std::size_t k = first; k < end; ++k) {
      cross += (a[k] * std::conj(b[k])).real();
      power_a += std::norm(a[k]);
      power_b += std::norm(b[k]);
    }
  }
  double value() const { return cross / std::sqrt(power_a * power_b); }
};

}  // namespace roseau::synthesis
