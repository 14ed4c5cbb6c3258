#include "estimation/identify.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "estimation/nelder_mead.h"

namespace roseau::estimation {

namespace {

using std::numbers::pi;

constexpr int kOversampling = 4;
constexpr int kHalfWidthBins = 6;       // beyond it a sine taper's spectral window is below 1e-4 of its peak
constexpr std::size_t kFewestBins = 8;  // to tell five parameters apart at all
constexpr double kForbidden = 1e12;
constexpr double kFloorLogSd = 1;  // of the weak prior that ties the floor to the spectrum's upper end

struct Band {
  std::size_t first = 0;
  std::size_t last = 0;
  std::size_t size() const { return last < first ? 0 : last - first + 1; }
};

Band fit_band(const Spectrum& spectrum, double resonance_hz, const IdentifyOptions& options) {
  const double bins = resonance_hz / spectrum.bin_hz();
  const std::size_t reach = static_cast<std::size_t>(kHalfWidthBins) + 1;
  if (spectrum.power.size() <= 2 * reach) return {1, 0};
  const std::size_t first = std::max(reach, static_cast<std::size_t>(options.fit_low * bins));
  const std::size_t last = std::min(spectrum.power.size() - reach, static_cast<std::size_t>(options.fit_high * bins));
  return {first, last};
}

// Model against spectrum over one band. Frequencies are in units of the resonance found first, powers in units of the series'
// variance, so that every parameter is of order one.
class WhittleLikelihood {
 public:
  WhittleLikelihood(const Spectrum& spectrum, double unit_power, double resonance_hz, std::size_t decimation,
                    const IdentifyOptions& options)
      : options_(options), band_(fit_band(spectrum, resonance_hz, options)) {
    window_ = taper_window(spectrum.samples, kHalfWidthBins, kOversampling);
    for (std::size_t bin = band_.first; bin <= band_.last; ++bin) power_.push_back(spectrum.power[bin] / unit_power);
    const auto reach = static_cast<std::size_t>(kHalfWidthBins);
    for (std::size_t i = (band_.first - reach) * kOversampling; i <= (band_.last + reach) * kOversampling; ++i) {
      const double hz = static_cast<double>(i) * spectrum.bin_hz() / kOversampling;
      const double ratio = hz / resonance_hz;
      squared_ratio_.push_back(ratio * ratio);
      log_ratio_.push_back(std::log(ratio));
      gain_.push_back(decimation_power_gain(decimation, 2 * pi * hz * spectrum.sample_period_s));
    }
    fine_.resize(squared_ratio_.size());
    high_floor_ = high_end(spectrum) / unit_power;
  }

  double high_floor() const { return high_floor_; }

  // Mean scale A that makes the oscillator as strong as the spectrum near its resonance.
  double start_scale(double damping_ratio) const {
    double measured = 0;
    double modelled = 0;
    const double g = 2 * damping_ratio;
    for (std::size_t i = 0; i < power_.size(); ++i) {
      const double q2 = squared_ratio_[fine_index(i)];
      if (std::abs(std::sqrt(q2) - 1) >= 0.3) continue;
      measured += power_[i];
      modelled += 1 / ((1 - q2) * (1 - q2) + g * g * q2);
    }
    return modelled > 0 && measured > 0 ? measured / modelled : 1e-6;
  }

  // theta = ln A, ln(w0/wh), ln(g/wh), ln B [, p]
  double oscillator(std::span<const double> theta) {
    const double frequency = std::exp(theta[1]);
    const double gamma = std::exp(theta[2]);
    if (frequency < 0.5 || frequency > 2 || gamma < 1e-3 || gamma > 2) return kForbidden;
    const double slope = theta.size() > 4 ? theta[4] : options_.force_slope;
    const double f2 = frequency * frequency;
    for (std::size_t i = 0; i < fine_.size(); ++i) {
      const double q2 = squared_ratio_[i];
      const double detuning = f2 - q2;
      fine_[i] = gain_[i] * std::exp(theta[0] - slope * log_ratio_[i]) / (detuning * detuning + gamma * gamma * q2);
    }
    double cost = deviance(std::exp(theta[3])) + floor_prior(theta[3]);
    if (theta.size() > 4) cost += square((slope - options_.force_slope) / options_.force_slope_sd) / 2;
    if (options_.damping_prior) {
      const double log_ratio = theta[2] - theta[1] - std::log(2 * options_.damping_prior->median_ratio);
      cost += square(log_ratio / options_.damping_prior->log_sd) / 2;
    }
    return cost;
  }

  // The same without a resonance: theta = ln A, ln B, p. What drift or gusts on a stiff target would look like.
  double power_law(std::span<const double> theta) {
    if (theta[2] < -1 || theta[2] > 8) return kForbidden;
    for (std::size_t i = 0; i < fine_.size(); ++i) fine_[i] = gain_[i] * std::exp(theta[0] - theta[2] * log_ratio_[i]);
    return deviance(std::exp(theta[1])) + floor_prior(theta[1]);
  }

 private:
  static double square(double x) { return x * x; }
  static std::size_t fine_index(std::size_t i) { return (i + kHalfWidthBins) * kOversampling; }

  // Whittle's negative log-likelihood of the smeared model plus a white floor. Each of the tapers counts as one look.
  double deviance(double floor) const {
    const Eigen::Map<const Eigen::VectorXd> window(window_.data(), static_cast<Eigen::Index>(window_.size()));
    double sum = 0;
    for (std::size_t i = 0; i < power_.size(); ++i) {
      const double* at = fine_.data() + i * kOversampling;
      const double expected = window.dot(Eigen::Map<const Eigen::VectorXd>(at, window.size())) + floor;
      sum += std::log(expected) + power_[i] / expected;
    }
    return kTaperCount * sum;
  }

  double floor_prior(double log_floor) const { return square((log_floor - std::log(high_floor_)) / kFloorLogSd) / 2; }

  // The white floor shows where the oscillator no longer does: median of the top fifth.
  static double high_end(const Spectrum& spectrum) {
    const std::size_t begin = spectrum.power.size() * 4 / 5;
    std::vector<double> top(spectrum.power.begin() + static_cast<std::ptrdiff_t>(begin), spectrum.power.end());
    const auto middle = top.begin() + static_cast<std::ptrdiff_t>(top.size() / 2);
    std::ranges::nth_element(top, middle);
    const double total = *std::ranges::max_element(spectrum.power);
    return std::max(*middle, total * 1e-15);  // a noise-free simulation has no floor, but a logarithm needs one
  }

  const IdentifyOptions& options_;
  Band band_;
  std::vector<double> window_;
  std::vector<double> power_;
  std::vector<double> squared_ratio_;
  std::vector<double> log_ratio_;
  std::vector<double> gain_;
  std::vector<double> fine_;
  double high_floor_ = 0;
};

// Highest line of the 5-line mean after dividing by the expected slope of the force.
double find_resonance(const Spectrum& spectrum, const IdentifyOptions& options) {
  const double bin_hz = spectrum.bin_hz();
  const std::size_t count = spectrum.power.size();
  const std::size_t first = std::max<std::size_t>(3, static_cast<std::size_t>(options.min_frequency_hz / bin_hz));
  const std::size_t last = std::min(count - 3, static_cast<std::size_t>(options.max_frequency_hz / bin_hz));
  double best = -1;
  std::size_t best_bin = 0;
  for (std::size_t i = first; i <= last; ++i) {
    double mean = 0;
    for (std::size_t j = i - 2; j <= i + 2; ++j) mean += spectrum.power[j] / 5;
    const double whitened = mean * std::pow(static_cast<double>(i), options.force_slope);
    if (whitened > best) {
      best = whitened;
      best_bin = i;
    }
  }
  return static_cast<double>(best_bin) * bin_hz;  // 0 when the band holds no line
}

struct Decimated {
  Spectrum spectrum;
  std::size_t factor = 1;
  double variance = 0;
};

Decimated decimated_spectrum(std::span<const double> series, double sample_period_s, double rate_hz) {
  Decimated result;
  result.factor = static_cast<std::size_t>(std::max(1.0, std::round(1 / (sample_period_s * rate_hz))));
  const std::vector<double> slow = detrend(decimate(series, result.factor));
  for (const double value : slow) result.variance += value * value / static_cast<double>(slow.size());
  if (slow.size() >= 8) {
    result.spectrum = multitaper_spectrum(slow, sample_period_s * static_cast<double>(result.factor));
  }
  return result;
}

double square_mean(std::span<const double> series) {
  double sum = 0;
  for (const double value : series) sum += value * value;
  return sum / static_cast<double>(series.size());
}

Result<void> check_series(std::span<const double> series, double sample_period_s, const IdentifyOptions& options) {
  if (!(sample_period_s > 0)) return Error{ErrorCode::invalid_argument, "identification needs a positive sample period"};
  if (!std::ranges::all_of(series, [](double value) { return std::isfinite(value); })) {
    return Error{ErrorCode::invalid_argument,
                 "the displacement series holds values that are not finite: fill or cut them first"};
  }
  const double duration_s = static_cast<double>(series.size()) * sample_period_s;
  const double periods = duration_s * options.min_frequency_hz;
  if (series.size() < 32 || periods < 4) {
    return Error{ErrorCode::invalid_argument,
                 fmt::format("{} samples ({:.1f} s) are too few to look for a resonance from {} Hz on: at least 32 samples and "
                             "4 periods are needed",
                             series.size(), duration_s, options.min_frequency_hz)};
  }
  return {};
}

std::vector<double> fit(WhittleLikelihood& likelihood, const IdentifyOptions& options, double& best_cost) {
  const bool free_slope = options.force_slope_sd > 0;
  std::vector<double> best;
  best_cost = kForbidden * 2;
  for (const double damping_ratio : options.start_damping_ratios) {
    std::vector<double> start = {std::log(likelihood.start_scale(damping_ratio)), 0, std::log(2 * damping_ratio),
                                 std::log(likelihood.high_floor())};
    std::vector<double> steps = {1, 0.05, 0.7, 0.7};
    if (free_slope) {
      start.push_back(options.force_slope);
      steps.push_back(0.3);
    }
    const auto result =
        minimise_simplex([&](std::span<const double> theta) { return likelihood.oscillator(theta); }, start, steps);
    if (result.value < best_cost) {
      best_cost = result.value;
      best = result.parameters;
    }
  }
  return best;
}

double cost_without_resonance(WhittleLikelihood& likelihood) {
  const double start[] = {std::log(likelihood.start_scale(0.5)), std::log(likelihood.high_floor()), 2};
  const double steps[] = {1, 0.7, 1};
  return minimise_simplex([&](std::span<const double> theta) { return likelihood.power_law(theta); }, start, steps).value;
}

double log_gamma_sd(double gamma_per_s, double duration_s, const IdentifyOptions& options) {
  double information = gamma_per_s * duration_s / 2;
  if (options.damping_prior) information += 1 / (options.damping_prior->log_sd * options.damping_prior->log_sd);
  return 1 / std::sqrt(information);
}

}  // namespace

double OscillatorFit::noise_density() const {
  // The floor seen after averaging `decimation` samples is noise_sd^2 / decimation per slow sample.
  return 2 * spectrum.sample_period_s * noise_sd * noise_sd / static_cast<double>(decimation);
}

double OscillatorFit::model_density(double frequency_hz) const {
  const double w = 2 * pi * frequency_hz;
  const double w0 = 2 * pi * natural_frequency_hz;
  const double detuning = w0 * w0 - w * w;
  const double force = force_density * std::pow(std::max(frequency_hz, 1e-9) / natural_frequency_hz, -force_slope);
  return force / (detuning * detuning + gamma_per_s * gamma_per_s * w * w) + noise_density();
}

Result<OscillatorFit> identify(std::span<const double> series, double sample_period_s, const IdentifyOptions& options) {
  if (auto checked = check_series(series, sample_period_s, options); !checked) return checked.error();

  Decimated slow = decimated_spectrum(series, sample_period_s, std::max(options.min_rate_hz, 2.5 * options.max_frequency_hz));
  double resonance_hz = slow.spectrum.power.size() > 6 ? find_resonance(slow.spectrum, options) : 0;
  const double rate_hz = std::max(options.min_rate_hz, options.rate_per_frequency * resonance_hz);
  const auto factor = static_cast<std::size_t>(std::max(1.0, std::round(1 / (sample_period_s * rate_hz))));
  if (factor != slow.factor) slow = decimated_spectrum(series, sample_period_s, rate_hz);
  if (resonance_hz <= 0 || slow.spectrum.power.empty() || fit_band(slow.spectrum, resonance_hz, options).size() < kFewestBins) {
    return Error{
        ErrorCode::invalid_argument,
        fmt::format("a record of {:.1f} s has too few spectral lines between {} and {} Hz: record longer or widen the band",
                    static_cast<double>(series.size()) * sample_period_s, options.min_frequency_hz, options.max_frequency_hz)};
  }
  if (!(slow.variance > 1e-24 * square_mean(series)))
    return Error{ErrorCode::invalid_argument, "the displacement series does not move"};

  WhittleLikelihood likelihood(slow.spectrum, slow.variance, resonance_hz, slow.factor, options);
  double cost = 0;
  const std::vector<double> theta = fit(likelihood, options, cost);
  const double scale = std::exp(theta[0]);
  const double relative_frequency = std::exp(theta[1]);
  const double relative_gamma = std::exp(theta[2]);
  const double floor = std::exp(theta[3]);
  const double resonance_rad = 2 * pi * resonance_hz;

  OscillatorFit result;
  result.decimation = slow.factor;
  result.duration_s = slow.spectrum.duration_s();
  result.natural_frequency_hz = relative_frequency * resonance_hz;
  result.gamma_per_s = relative_gamma * resonance_rad;
  result.damping_ratio = relative_gamma / (2 * relative_frequency);
  result.natural_frequency_sd_hz = std::sqrt(result.gamma_per_s / (2 * result.duration_s)) / (2 * pi);
  result.damping_ratio_sd = result.damping_ratio * log_gamma_sd(result.gamma_per_s, result.duration_s, options);
  result.force_slope = theta.size() > 4 ? theta[4] : options.force_slope;
  result.noise_sd = std::sqrt(floor * slow.variance * static_cast<double>(slow.factor));
  const double force = scale * std::pow(relative_frequency, -result.force_slope);
  result.force_density = 2 * slow.spectrum.sample_period_s * slow.variance * force * std::pow(resonance_rad, 4);
  const double peak = force / (relative_gamma * relative_gamma * relative_frequency * relative_frequency);
  result.peak_to_floor = peak / floor;
  result.resonance_gain = (cost_without_resonance(likelihood) - cost) / kTaperCount;
  result.accepted = result.peak_to_floor > options.gate && result.resonance_gain > options.resonance_gain;
  result.spectrum = std::move(slow.spectrum);
  return result;
}

}  // namespace roseau::estimation
