#include "tests/support/sway_simulation.h"

#include <Eigen/Core>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <unsupported/Eigen/MatrixFunctions>

#include "estimation/fourier.h"

namespace roseau::testing {

namespace {

using std::numbers::pi;

double mean_of(std::span<const double> series) {
  return std::accumulate(series.begin(), series.end(), 0.0) / static_cast<double>(series.size());
}

double sd_of(std::span<const double> series) {
  const double mean = mean_of(series);
  double sum = 0;
  for (const double value : series) sum += (value - mean) * (value - mean);
  return std::sqrt(sum / static_cast<double>(series.size()));
}

}  // namespace

double GaussianSource::uniform() { return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1p-53; }

double GaussianSource::normal() {
  const double radius = std::sqrt(-2 * std::log(uniform()));
  return radius * std::cos(2 * pi * uniform());
}

double PortableRandom::uniform() {
  state_ = (1103515245ULL * state_ + 12345ULL) % 2147483648ULL;
  return (static_cast<double>(state_) + 0.5) / 2147483648.0;
}

std::vector<double> von_karman_wind(GaussianSource& random, std::size_t samples, double sample_period_s,
                                    const WindOptions& options) {
  const std::size_t length = estimation::fast_length_at_least(samples);
  std::vector<std::complex<double>> bins(length / 2 + 1);
  for (std::size_t i = 1; i < bins.size(); ++i) {
    const double hz = static_cast<double>(i) / (static_cast<double>(length) * sample_period_s);
    const double reduced = hz * options.length_scale_m / options.mean_mps;
    const double amplitude = std::pow(1 + 70.8 * reduced * reduced, -5.0 / 12);
    const double real = random.normal();
    bins[i] = amplitude * std::complex<double>(real, random.normal());
  }
  std::vector<double> wind = estimation::inverse_real_fft(bins, length);
  wind.resize(samples);
  const double mean = mean_of(wind);
  const double scale = options.turbulence_intensity * options.mean_mps / sd_of(wind);
  for (double& value : wind) value = options.mean_mps + (value - mean) * scale;
  return wind;
}

std::vector<double> oscillator_response(std::span<const double> force, double sample_period_s, double w0_rad_s,
                                        double gamma_per_s) {
  // States x, x', force and its slope over the step.
  Eigen::Matrix4d rate = Eigen::Matrix4d::Zero();
  rate << 0, 1, 0, 0, -w0_rad_s * w0_rad_s, -gamma_per_s, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0;
  const Eigen::Matrix4d step = (rate * sample_period_s).exp();
  std::vector<double> response(force.size());
  double x = force[0] / (w0_rad_s * w0_rad_s);
  double v = 0;
  for (std::size_t i = 0; i < force.size(); ++i) {
    response[i] = x;
    if (i + 1 == force.size()) break;
    const Eigen::Vector4d state(x, v, force[i], (force[i + 1] - force[i]) / sample_period_s);
    x = step.row(0).dot(state);
    v = step.row(1).dot(state);
  }
  return response;
}

std::vector<double> zero_phase_low_pass(std::span<const double> series, double sample_period_s, double cut_hz) {
  const double mean = mean_of(series);
  std::vector<double> centred(series.begin(), series.end());
  for (double& value : centred) value -= mean;
  auto bins = estimation::real_fft(centred);
  for (std::size_t i = 0; i < bins.size(); ++i) {
    const double hz = static_cast<double>(i) / (static_cast<double>(series.size()) * sample_period_s);
    bins[i] /= 1 + std::pow(hz / cut_hz, 16);
  }
  std::vector<double> result = estimation::inverse_real_fft(bins, series.size());
  for (double& value : result) value += mean;
  return result;
}

double correlation(std::span<const double> a, std::span<const double> b) {
  const double mean_a = mean_of(a);
  const double mean_b = mean_of(b);
  double ab = 0;
  double aa = 0;
  double bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - mean_a) * (b[i] - mean_b);
    aa += (a[i] - mean_a) * (a[i] - mean_a);
    bb += (b[i] - mean_b) * (b[i] - mean_b);
  }
  return ab / std::sqrt(aa * bb);
}

double rms_difference(std::span<const double> a, std::span<const double> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

Sway simulate_sway(std::uint64_t seed, const SwayOptions& options) {
  GaussianSource random(seed);
  // The air moves faster than the camera looks.
  const std::size_t oversampling = options.rate_hz >= 50 ? 2 : 4;
  const auto frames = static_cast<std::size_t>(std::llround(options.duration_s * options.rate_hz));
  const auto run_up = static_cast<std::size_t>(std::llround(40 * options.rate_hz));
  const double fine_period_s = 1 / (options.rate_hz * static_cast<double>(oversampling));
  const auto wind = von_karman_wind(random, (frames + run_up) * oversampling, fine_period_s, options.wind);
  const double w0 = 2 * pi * options.natural_frequency_hz;

  Sway sway;
  sway.sample_period_s = 1 / options.rate_hz;
  sway.force_per_drag = options.mean_deflection_px * w0 * w0 / std::pow(options.wind.mean_mps, options.drag_exponent);
  std::vector<double> force(wind.size());
  for (std::size_t i = 0; i < wind.size(); ++i) {
    force[i] = sway.force_per_drag * std::copysign(std::pow(std::abs(wind[i]), options.drag_exponent), wind[i]);
  }
  const auto position = oscillator_response(force, fine_period_s, w0, 2 * options.damping_ratio * w0);
  for (std::size_t i = 0; i < frames; ++i) {
    const std::size_t at = (run_up + i) * oversampling;
    sway.wind_mps.push_back(wind[at]);
    sway.force.push_back(force[at]);
    sway.displacement_px.push_back(position[at] + options.rest_offset_px + options.noise_px * random.normal());
  }
  return sway;
}

}  // namespace roseau::testing
