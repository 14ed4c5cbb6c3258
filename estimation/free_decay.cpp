#include "estimation/free_decay.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "estimation/fourier.h"
#include "estimation/multitaper.h"
#include "estimation/nelder_mead.h"

namespace roseau::estimation {

namespace {

using std::numbers::pi;
using Basis = Eigen::Matrix<double, Eigen::Dynamic, 4>;
using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, 6>;

constexpr double kMaxDampingRatio = 0.5;  // beyond it there is no oscillation left to fit
constexpr double kMinDampingRatio = 1e-4;
constexpr double kSamplesPerPeriod = 16;  // more than this only costs time
constexpr int kResidualTapers = 6;        // residuals are few and their spectrum wanted smooth
constexpr int kStartCandidates = 5;       // half periods after the release that may be left out
constexpr double kTailTolerance = 0.1;    // of the tail's variance

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

// Release: the end of the first swing that is about as large as the largest; where the target was held there, the end of the
// hold.
std::size_t find_release(const std::vector<double>& series) {
  const double rest = median_of(series);
  const auto deflection = [&](std::size_t i) { return std::abs(series[i] - rest); };
  double largest = 0;
  for (std::size_t i = 0; i < series.size(); ++i) largest = std::max(largest, deflection(i));
  std::size_t first = 0;
  while (deflection(first) < 0.8 * largest) ++first;
  double peak = 0;
  std::size_t release = first;
  for (std::size_t i = first; i < series.size() && (series[i] - rest) * (series[first] - rest) > 0; ++i) {
    peak = std::max(peak, deflection(i));
    if (deflection(i) >= 0.9 * peak) release = i;
  }
  return release;
}

double peak_in_band(std::span<const double> series, double sample_period_s, const FrequencyBand& band) {
  std::vector<double> padded = detrend(series);
  padded.resize(fast_length_at_least(8 * series.size()), 0.0);
  const auto bins = real_fft(padded);
  const double bin_hz = 1 / (static_cast<double>(padded.size()) * sample_period_s);
  const auto first = static_cast<std::size_t>(std::ceil(band.min_hz / bin_hz));
  const auto last = std::min(bins.size() - 1, static_cast<std::size_t>(band.max_hz / bin_hz));
  std::size_t best = first;
  for (std::size_t i = first; i <= last; ++i) {
    if (std::norm(bins[i]) > std::norm(bins[best])) best = i;
  }
  return static_cast<double>(best) * bin_hz;
}

struct Oscillation {
  double w0 = 0;
  double damping_ratio = 0;
};

// The decay being fitted and its model.
class Decay {
 public:
  Decay(std::span<const double> series, double sample_period_s) : sample_period_s_(sample_period_s) {
    values_ = Eigen::Map<const Eigen::VectorXd>(series.data(), static_cast<Eigen::Index>(series.size()));
  }

  double duration_s() const { return static_cast<double>(values_.size()) * sample_period_s_; }

  std::size_t samples() const { return static_cast<std::size_t>(values_.size()); }

  Eigen::Vector4d amplitudes(const Oscillation& found) const {
    return basis(found.w0, found.damping_ratio).colPivHouseholderQr().solve(values_);
  }

  Eigen::VectorXd residuals(const Oscillation& found) const {
    const Basis columns = basis(found.w0, found.damping_ratio);
    return values_ - columns * columns.colPivHouseholderQr().solve(values_);
  }

  // Share of the last `count` samples' variance (about their own offset and drift) that the fit of the whole leaves over.
  double unexplained(const Oscillation& found, std::size_t count) const {
    const auto tail = static_cast<Eigen::Index>(count);
    double variance = 0;
    for (const double value : detrend({values_.data() + values_.size() - tail, count})) variance += value * value;
    return variance > 0 ? residuals(found).tail(tail).squaredNorm() / variance : 0;
  }

  bool moves() const { return (values_.array() != values_[0]).any(); }

  // Columns: derivatives by w0, zeta, a, b, c, d.
  Jacobian jacobian(const Oscillation& found) const {
    const auto [w0, damping_ratio] = found;
    const Eigen::Vector4d linear = amplitudes(found);
    const double root = std::sqrt(1 - damping_ratio * damping_ratio);
    Jacobian result(values_.size(), 6);
    result.rightCols<4>() = basis(w0, damping_ratio);
    for (Eigen::Index i = 0; i < values_.size(); ++i) {
      const double t = time_s(i);
      const double in_phase = linear[0] * result(i, 2) + linear[1] * result(i, 3);
      const double quadrature = linear[1] * result(i, 2) - linear[0] * result(i, 3);
      result(i, 0) = t * (root * quadrature - damping_ratio * in_phase);
      result(i, 1) = -w0 * t * (in_phase + damping_ratio / root * quadrature);
    }
    return result;
  }

 private:
  double time_s(Eigen::Index i) const { return static_cast<double>(i) * sample_period_s_; }

  Basis basis(double w0, double damping_ratio) const {
    Basis columns(values_.size(), 4);
    const double damped = w0 * std::sqrt(1 - damping_ratio * damping_ratio);
    for (Eigen::Index i = 0; i < values_.size(); ++i) {
      const double t = time_s(i);
      const double envelope = std::exp(-damping_ratio * w0 * t);
      columns.row(i) << envelope * std::cos(damped * t), envelope * std::sin(damped * t), 1, t / duration_s();
    }
    return columns;
  }

  Eigen::VectorXd values_;
  double sample_period_s_;
};

// Coarse grid round the spectral peak, then a simplex from its best point.
Oscillation search(const Decay& decay, double peak_hz, const FrequencyBand& band) {
  const auto cost = [&](double hz, double damping_ratio) {
    if (hz < band.min_hz || hz > band.max_hz || damping_ratio < kMinDampingRatio || damping_ratio > kMaxDampingRatio) {
      return 1e6;
    }
    return std::log(decay.residuals({2 * pi * hz, damping_ratio}).squaredNorm() + 1e-300);
  };
  const double step_hz = 0.25 / decay.duration_s();
  double best = 1e9;
  double start[2] = {std::log(peak_hz), std::log(0.05)};
  for (int i = -8; i <= 8; ++i) {
    const double hz = std::clamp(peak_hz + i * step_hz, band.min_hz, band.max_hz);
    for (const double damping_ratio : {0.005, 0.015, 0.03, 0.06, 0.12, 0.25}) {
      const double value = cost(hz, damping_ratio);
      if (value >= best) continue;
      best = value;
      start[0] = std::log(hz);
      start[1] = std::log(damping_ratio);
    }
  }
  const double steps[2] = {step_hz / peak_hz, 0.3};
  SimplexOptions options;
  options.parameter_tolerance = 1e-7;
  options.value_tolerance = 1e-10;
  const auto result = minimise_simplex(
      [&](std::span<const double> theta) { return cost(std::exp(theta[0]), std::exp(theta[1])); }, start, steps, options);
  return {2 * pi * std::exp(result.parameters[0]), std::exp(result.parameters[1])};
}

// J'RJ in the frequency domain: R is stationary with the residuals' spectrum, so it acts on each column by multiplication.
Eigen::Matrix<double, 6, 6> coloured_product(const Jacobian& jacobian, const Spectrum& residual_spectrum) {
  const auto samples = static_cast<std::size_t>(jacobian.rows());
  const std::size_t padded = fast_length_at_least(2 * samples);
  std::vector<std::vector<std::complex<double>>> columns;
  for (Eigen::Index column = 0; column < 6; ++column) {
    std::vector<double> values(padded, 0.0);
    std::copy_n(jacobian.col(column).data(), samples, values.begin());
    columns.push_back(real_fft(values));
  }
  Eigen::Matrix<double, 6, 6> product = Eigen::Matrix<double, 6, 6>::Zero();
  const double lines_per_bin = static_cast<double>(samples) / static_cast<double>(padded);
  for (std::size_t i = 0; i < columns[0].size(); ++i) {
    const double line = static_cast<double>(i) * lines_per_bin;
    const std::size_t below = std::min(static_cast<std::size_t>(line), residual_spectrum.power.size() - 2);
    const double weight = line - static_cast<double>(below);
    const double power = (1 - weight) * residual_spectrum.power[below] + weight * residual_spectrum.power[below + 1];
    const bool is_double = i != 0 && 2 * i != padded;
    for (int a = 0; a < 6; ++a) {
      for (int b = 0; b < 6; ++b) {
        const auto term = std::conj(columns[static_cast<std::size_t>(a)][i]) * columns[static_cast<std::size_t>(b)][i];
        product(a, b) += (is_double ? 2 : 1) * power * term.real() / static_cast<double>(padded);
      }
    }
  }
  return product;
}

Eigen::Matrix<double, 6, 6> covariance(const Decay& decay, const Oscillation& found, double sample_period_s) {
  const Jacobian jacobian = decay.jacobian(found);
  const Eigen::VectorXd left = decay.residuals(found);
  Spectrum spectrum =
      multitaper_spectrum({left.data(), static_cast<std::size_t>(left.size())}, sample_period_s, kResidualTapers);
  const auto count = static_cast<double>(left.size());
  for (double& power : spectrum.power) power *= count / (count - 6);  // the fit took six degrees of freedom with it
  const Eigen::Matrix<double, 6, 6> inverse = (jacobian.transpose() * jacobian).inverse();
  return inverse * coloured_product(jacobian, spectrum) * inverse;
}

struct Start {
  std::size_t index = 0;  // samples after the release
  Oscillation found;
  Oscillation spread;  // RMS difference of the fits from the other starts that would have done as well
};

// The first swing after a release is often not yet the free decay: the rope is still there, higher modes ring. Of the starts at
// the release and up to two periods later, the earliest one is taken whose fit describes what follows those two periods
// (almost) as well as the best of them does.
Start choose_start(std::span<const double> series, double sample_period_s, const FrequencyBand& band) {
  const double peak_hz = peak_in_band(series, sample_period_s, band);
  const double half_period = 0.5 / (peak_hz * sample_period_s);
  std::vector<Start> starts;
  for (int k = 0; k < kStartCandidates; ++k) {
    const auto index = static_cast<std::size_t>(std::llround(k * half_period));
    // What is left must still hold two periods.
    if (k > 0 && static_cast<double>(series.size() - std::min(index, series.size())) < 4 * half_period) break;
    const Decay decay(series.subspan(index), sample_period_s);
    starts.push_back({index, search(decay, peak_in_band(series.subspan(index), sample_period_s, band), band), {}});
  }
  const std::size_t tail = series.size() - starts.back().index;
  const auto left_over = [&](const Start& start) {
    return Decay(series.subspan(start.index), sample_period_s).unexplained(start.found, tail);
  };
  double best = left_over(starts.front());
  for (const Start& start : starts) best = std::min(best, left_over(start));
  std::erase_if(starts, [&](const Start& start) { return left_over(start) > best + kTailTolerance; });
  Start chosen = starts.front();
  for (const Start& other : starts) {
    const auto share = static_cast<double>(std::max<std::size_t>(1, starts.size() - 1));
    chosen.spread.w0 += std::pow(other.found.w0 - chosen.found.w0, 2) / share;
    chosen.spread.damping_ratio += std::pow(other.found.damping_ratio - chosen.found.damping_ratio, 2) / share;
  }
  chosen.spread = {std::sqrt(chosen.spread.w0), std::sqrt(chosen.spread.damping_ratio)};
  return chosen;
}

Result<void> check_input(std::span<const double> series, double rate_hz, const FrequencyBand& band) {
  const auto refuse = [](std::string message) { return Error{ErrorCode::invalid_argument, std::move(message)}; };
  if (!(rate_hz > 0)) return refuse("the rate of a free decay must be positive");
  if (!(band.min_hz > 0 && band.max_hz > band.min_hz)) {
    return refuse(fmt::format("the band {} to {} Hz is empty: give a lower and a higher frequency", band.min_hz, band.max_hz));
  }
  if (band.max_hz > rate_hz / 2) {
    return refuse(fmt::format("the band reaches {} Hz, but {} samples per second only hold frequencies below {} Hz",
                              band.max_hz, rate_hz, rate_hz / 2));
  }
  if (!std::ranges::all_of(series, [](double value) { return std::isfinite(value); })) {
    return refuse("the series holds values that are not finite: fill or cut them first");
  }
  return {};
}

}  // namespace

Result<FreeDecay> fit_free_decay(std::span<const double> series, double rate_hz, const FrequencyBand& band) {
  if (auto checked = check_input(series, rate_hz, band); !checked) return checked.error();
  const auto factor = static_cast<std::size_t>(std::max(1.0, std::floor(rate_hz / (kSamplesPerPeriod * band.max_hz))));
  const double sample_period_s = static_cast<double>(factor) / rate_hz;
  const std::vector<double> slow = decimate(series, factor);
  const std::size_t release = slow.empty() ? 0 : find_release(slow);
  const auto tail = std::span(slow).subspan(release);
  const double tail_s = static_cast<double>(tail.size()) * sample_period_s;
  if (tail.size() < 16 || tail_s * band.min_hz < 2) {
    return Error{
        ErrorCode::invalid_argument,
        fmt::format("only {} samples ({:.1f} s) follow the release: a decay needs at least 16 samples and two periods of "
                    "the band's lowest frequency",
                    tail.size() * factor, tail_s)};
  }
  if (!Decay(tail, sample_period_s).moves()) return Error{ErrorCode::invalid_argument, "the series does not move"};

  const Start start = choose_start(tail, sample_period_s, band);
  const Decay decay(tail.subspan(start.index), sample_period_s);
  const auto left_out = static_cast<double>(series.size() % factor) / rate_hz;
  const Eigen::Matrix<double, 6, 6> uncertainty = covariance(decay, start.found, sample_period_s);

  FreeDecay result;
  result.start_s = static_cast<double>(release + start.index) * sample_period_s + left_out;
  result.duration_s = decay.duration_s();
  result.resolution_hz = rate_hz / static_cast<double>(series.size());
  result.spectral_peak_hz = peak_in_band(tail.subspan(start.index), sample_period_s, band);
  result.natural_frequency_hz = start.found.w0 / (2 * pi);
  result.natural_frequency_sd_hz = std::hypot(std::sqrt(std::max(0.0, uncertainty(0, 0))), start.spread.w0) / (2 * pi);
  result.damping_ratio = start.found.damping_ratio;
  result.damping_ratio_sd = std::hypot(std::sqrt(std::max(0.0, uncertainty(1, 1))), start.spread.damping_ratio);
  result.amplitude = decay.amplitudes(start.found).head<2>().norm();
  result.explained = 1 - decay.unexplained(start.found, decay.samples());
  return result;
}

}  // namespace roseau::estimation
