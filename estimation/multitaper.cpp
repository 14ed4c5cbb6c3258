#include "estimation/multitaper.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>

#include "core/check.h"
#include "estimation/fourier.h"

namespace roseau::estimation {

namespace {

using std::numbers::pi;

// sum_{t=0}^{n-1} exp(-j x t)
std::complex<double> geometric_sum(double x, double n) {
  const double half = std::sin(x / 2);
  const double magnitude = std::abs(half) < 1e-12 ? n : std::sin(n * x / 2) / half;
  return std::polar(1.0, -x * (n - 1) / 2) * magnitude;
}

// Transform of taper k at angular frequency w (radians per sample), from its two complex exponentials.
std::complex<double> taper_transform(int k, double n, double w) {
  const double step = pi * k / (n + 1);
  const std::complex<double> up = std::polar(1.0, step) * geometric_sum(w - step, n);
  const std::complex<double> down = std::polar(1.0, -step) * geometric_sum(w + step, n);
  return std::sqrt(2 / (n + 1)) * (up - down) / std::complex<double>(0, 2);
}

}  // namespace

Spectrum multitaper_spectrum(std::span<const double> series, double sample_period_s, int tapers) {
  ROSEAU_CHECK(series.size() >= 8 && sample_period_s > 0 && tapers >= 1);
  const std::size_t n = series.size();
  Spectrum spectrum{std::vector<double>(n / 2 + 1, 0.0), n, sample_period_s};
  const double scale = std::sqrt(2 / (static_cast<double>(n) + 1));
  std::vector<double> tapered(n);
  for (int k = 1; k <= tapers; ++k) {
    const double step = pi * k / (static_cast<double>(n) + 1);
    for (std::size_t t = 0; t < n; ++t) tapered[t] = series[t] * scale * std::sin(step * (static_cast<double>(t) + 1));
    const auto bins = real_fft(tapered);
    for (std::size_t i = 0; i < bins.size(); ++i) spectrum.power[i] += std::norm(bins[i]) / tapers;
  }
  return spectrum;
}

std::vector<double> taper_window(std::size_t samples, int half_width_bins, int oversampling, int tapers) {
  ROSEAU_CHECK(samples >= 8 && half_width_bins >= 1 && oversampling >= 1);
  const auto n = static_cast<double>(samples);
  const int reach = half_width_bins * oversampling;
  std::vector<double> window;
  window.reserve(2 * static_cast<std::size_t>(reach) + 1);
  for (int offset = -reach; offset <= reach; ++offset) {
    const double w = 2 * pi * offset / (n * oversampling);
    double power = 0;
    for (int k = 1; k <= tapers; ++k) power += std::norm(taper_transform(k, n, w));
    window.push_back(power);
  }
  const double total = std::accumulate(window.begin(), window.end(), 0.0);
  for (double& value : window) value /= total;
  return window;
}

std::vector<double> decimate(std::span<const double> series, std::size_t factor) {
  ROSEAU_CHECK(factor >= 1);
  const std::size_t count = series.size() / factor;
  const auto used = series.last(count * factor);
  std::vector<double> result(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto group = used.subspan(i * factor, factor);
    result[i] = std::accumulate(group.begin(), group.end(), 0.0) / static_cast<double>(factor);
  }
  return result;
}

double decimation_power_gain(std::size_t factor, double radians_per_output_sample) {
  const auto k = static_cast<double>(factor);
  const double half = radians_per_output_sample / (2 * k);
  const double below = k * std::sin(half);
  if (std::abs(below) < 1e-9) return 1;
  const double gain = std::sin(k * half) / below;
  return gain * gain;
}

std::vector<double> detrend(std::span<const double> series) {
  const auto n = static_cast<double>(series.size());
  const double mean = std::accumulate(series.begin(), series.end(), 0.0) / n;
  const double centre = (n - 1) / 2;
  double moment = 0;
  double spread = 0;
  for (std::size_t t = 0; t < series.size(); ++t) {
    const double at = static_cast<double>(t) - centre;
    moment += at * series[t];
    spread += at * at;
  }
  const double slope = spread > 0 ? moment / spread : 0;
  std::vector<double> result(series.size());
  for (std::size_t t = 0; t < series.size(); ++t) result[t] = series[t] - mean - slope * (static_cast<double>(t) - centre);
  return result;
}

}  // namespace roseau::estimation
