// online: wind from a swaying target on line, 27 targets and cameras (f0 x damping x camera), force k V|V| of a von Karman wind
// of 4 m/s, mean deflection 10 px. Identified from the first 120 s, scored on the next 480 s: estimate and truth go through the
// same zero-phase filter, so a figure says how good the estimate is in that band at that lag. Beside them a lag of 20 s, which
// is as good as a batch smoother gets: the floor.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "bench/bench.h"
#include "bench/estimation_cases.h"
#include "estimation/fourier.h"
#include "estimation/identify.h"
#include "estimation/latent_force_kalman.h"
#include "tests/support/sway_simulation.h"

namespace roseau::bench {

namespace {

constexpr int kSeeds = 4;
constexpr double kIdentified_s = 120;
constexpr double kTested_s = 480;
constexpr double kEdge_s = 15;  // the filter's start and the band filter's ends are not scored
constexpr double kBatchLag_s = 20;
constexpr double kLags_s[] = {0, 0.1, 0.25, 0.5, 1, 2, kBatchLag_s};
constexpr double kBands_hz[] = {0.3, 1};

struct Camera {
  double rate_hz;
  double noise_px;
};

struct Score {
  double correlation = 0;
  double rms_mps = 0;
};

// Worst and median over the configurations; each configuration is the mean of its seeds.
struct Table {
  std::vector<double> correlation;
  std::vector<double> rms_mps;
};

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

double spread(std::span<const double> series, double& mean) {
  mean = 0;
  for (const double value : series) mean += value / static_cast<double>(series.size());
  double square = 0;
  for (const double value : series) square += (value - mean) * (value - mean) / static_cast<double>(series.size());
  return std::sqrt(square);
}

Result<estimation::LatentForceModel> identified_model(const testing::Sway& sway) {
  const auto count = static_cast<std::size_t>(kIdentified_s / sway.sample_period_s);
  const auto record = std::span(sway.displacement_px).first(count);
  const auto fit = estimation::identify(record, sway.sample_period_s);
  if (!fit) return fit.error();
  estimation::LatentForceModel model;
  model.natural_frequency_hz = fit->natural_frequency_hz;
  model.damping_ratio = fit->damping_ratio;
  model.sample_period_s = sway.sample_period_s;
  model.noise_sd = fit->noise_sd;
  model.static_sd = spread(testing::zero_phase_low_pass(record, sway.sample_period_s, 0.2), model.static_mean);
  return model;
}

// Wind estimated for every frame of the tested part. Smoothing looks `lag` ahead, and never past the record's end.
std::vector<double> estimate_wind(const testing::Sway& sway, const estimation::LatentForceModel& model, double lag_s,
                                  std::size_t first, double& nanoseconds) {
  const auto lag = static_cast<std::size_t>(std::llround(lag_s / sway.sample_period_s));
  estimation::LatentForceKalman filter(model, lag);
  filter.start(sway.displacement_px[first]);
  std::vector<double> wind;
  const double begin_s = thread_cpu_seconds();
  for (std::size_t i = first; i < sway.displacement_px.size(); ++i) {
    const auto estimate = filter.step(sway.displacement_px[i]);
    if (!estimate) continue;
    const double ratio = estimate->force_per_mass / sway.force_per_drag;
    wind.push_back(std::copysign(std::sqrt(std::abs(ratio)), ratio));
  }
  nanoseconds = 1e9 * (thread_cpu_seconds() - begin_s) / static_cast<double>(sway.displacement_px.size() - first);
  return wind;
}

Score score(const std::vector<double>& estimate, std::span<const double> truth, double sample_period_s, double band_hz) {
  const std::size_t count = estimation::fast_length_at_most(estimate.size());
  const auto a = testing::zero_phase_low_pass(std::span(estimate).first(count), sample_period_s, band_hz);
  const auto b = testing::zero_phase_low_pass(truth.first(count), sample_period_s, band_hz);
  const auto edge = static_cast<std::size_t>(kEdge_s / sample_period_s);
  const auto inner_a = std::span(a).subspan(edge, count - 2 * edge);
  const auto inner_b = std::span(b).subspan(edge, count - 2 * edge);
  return {testing::correlation(inner_a, inner_b), testing::rms_difference(inner_a, inner_b)};
}

std::string lag_name(double lag_s) {
  if (lag_s == kBatchLag_s) return "batch";
  const auto hundredths = static_cast<int>(std::lround(lag_s * 100));
  return "lag_" + std::to_string(hundredths / 100) + "p" + (hundredths % 100 < 10 ? "0" : "") +
         std::to_string(hundredths % 100);
}

class Grid {
 public:
  Result<void> run() {
    for (const double frequency_hz : {0.5, 1.0, 2.0}) {
      for (const double damping_ratio : {0.02, 0.05, 0.1}) {
        for (const Camera camera : {Camera{25, 0.5}, Camera{30, 0.3}, Camera{60, 0.1}}) {
          if (auto done = run_configuration(frequency_hz, damping_ratio, camera); !done) return done.error();
        }
      }
    }
    return {};
  }

  nlohmann::ordered_json figures() const {
    nlohmann::ordered_json result;
    result["case"] = "online";
    result["configurations"] = tables_[0][0].correlation.size();
    result["seeds"] = kSeeds;
    for (std::size_t band = 0; band < std::size(kBands_hz); ++band) {
      for (std::size_t lag = 0; lag < std::size(kLags_s); ++lag) {
        const Table& table = tables_[band][lag];
        const std::string prefix = kLags_s[lag] == kBatchLag_s ? "floor_" : "";
        const std::string name = prefix + (band == 0 ? "band_0p3_" : "band_1p0_") + lag_name(kLags_s[lag]);
        result[name + "_worst_correlation"] = *std::ranges::min_element(table.correlation);
        result[name + "_median_correlation"] = median(table.correlation);
        result[name + "_worst_rms_mps"] = *std::ranges::max_element(table.rms_mps);
        result[name + "_median_rms_mps"] = median(table.rms_mps);
      }
    }
    result["frequency_error_rms_percent"] = 100 * std::sqrt(frequency_square_ / runs_);
    result["gamma_error_rms_percent"] = 100 * std::sqrt(gamma_square_ / runs_);
    result["identification_ms"] = identification_ms_ / runs_;
    result["frame_at_lag_0p25_ns"] = frame_ns_ / runs_;
    return result;
  }

 private:
  Result<void> run_configuration(double frequency_hz, double damping_ratio, const Camera& camera) {
    Score sums[std::size(kBands_hz)][std::size(kLags_s)] = {};
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      testing::SwayOptions options;
      options.natural_frequency_hz = frequency_hz;
      options.damping_ratio = damping_ratio;
      options.rate_hz = camera.rate_hz;
      options.noise_px = camera.noise_px;
      options.duration_s = kIdentified_s + kTested_s;
      if (auto done = run_once(testing::simulate_sway(seed, options), options, sums); !done) return done.error();
    }
    for (std::size_t band = 0; band < std::size(kBands_hz); ++band) {
      for (std::size_t lag = 0; lag < std::size(kLags_s); ++lag) {
        tables_[band][lag].correlation.push_back(sums[band][lag].correlation / kSeeds);
        tables_[band][lag].rms_mps.push_back(sums[band][lag].rms_mps / kSeeds);
      }
    }
    return {};
  }

  Result<void> run_once(const testing::Sway& sway, const testing::SwayOptions& options,
                        Score (&sums)[std::size(kBands_hz)][std::size(kLags_s)]) {
    const double begin_s = thread_cpu_seconds();
    const auto model = identified_model(sway);
    if (!model) return model.error();
    identification_ms_ += 1e3 * (thread_cpu_seconds() - begin_s);
    runs_ += 1;
    const double gamma = model->damping_ratio * model->natural_frequency_hz;
    frequency_square_ += std::pow(model->natural_frequency_hz / options.natural_frequency_hz - 1, 2);
    gamma_square_ += std::pow(gamma / (options.damping_ratio * options.natural_frequency_hz) - 1, 2);

    const auto first = static_cast<std::size_t>(kIdentified_s / sway.sample_period_s);
    for (std::size_t lag = 0; lag < std::size(kLags_s); ++lag) {
      double nanoseconds = 0;
      const auto wind = estimate_wind(sway, *model, kLags_s[lag], first, nanoseconds);
      if (kLags_s[lag] == 0.25) frame_ns_ += nanoseconds;
      const auto truth = std::span(sway.wind_mps).subspan(first, wind.size());
      for (std::size_t band = 0; band < std::size(kBands_hz); ++band) {
        const Score got = score(wind, truth, sway.sample_period_s, kBands_hz[band]);
        sums[band][lag].correlation += got.correlation;
        sums[band][lag].rms_mps += got.rms_mps;
      }
    }
    return {};
  }

  Table tables_[std::size(kBands_hz)][std::size(kLags_s)];
  double frequency_square_ = 0;
  double gamma_square_ = 0;
  double identification_ms_ = 0;
  double frame_ns_ = 0;
  double runs_ = 0;
};

}  // namespace

Result<nlohmann::ordered_json> run_online() {
  Grid grid;
  if (auto done = grid.run(); !done) return done.error();
  return grid.figures();
}

}  // namespace roseau::bench
