// identify: how well natural frequency and damping come out of a record under a random force, as multiples of the floor that
// no identifier from so long a record can beat: sd(w0)/w0 = sqrt(g/2D)/w0, sd(g)/g = sqrt(2/(gD)).
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include "bench/bench.h"
#include "bench/estimation_cases.h"
#include "estimation/fourier.h"
#include "estimation/identify.h"
#include "tests/support/sway_simulation.h"

namespace roseau::bench {

namespace {

using estimation::IdentifyOptions;
using std::numbers::pi;
using testing::GaussianSource;

constexpr int kSeeds = 100;

struct Record {
  std::vector<double> displacement;
  double sample_period_s = 1;
  double w0_rad_s = 0;
  double gamma_per_s = 0;
};

double largest(const std::vector<double>& series) {
  double result = 0;
  for (const double value : series) result = std::max(result, std::abs(value));
  return result;
}

void add_noise(GaussianSource& random, std::vector<double>& series, double sd) {
  for (double& value : series) value += sd * random.normal();
}

constexpr std::size_t kThesisSamples = 513;
constexpr double kThesisW0 = 2 * pi * 30 / 513;
constexpr double kThesisGamma = 2 * pi * 10 / 513;

// VIDA thesis 5.6 with a Gaussian instead of a flat force: random amplitude and phase in every line, periodic.
Record thesis_periodic(std::uint64_t seed) {
  GaussianSource random(seed);
  std::vector<std::complex<double>> bins(kThesisSamples / 2 + 1);
  for (std::size_t i = 0; i < bins.size(); ++i) {
    const double w = 2 * pi * static_cast<double>(i) / static_cast<double>(kThesisSamples);
    const double real = random.normal();
    const std::complex<double> force(real, i == 0 ? 0.0 : random.normal());
    bins[i] = force / std::complex<double>(kThesisW0 * kThesisW0 - w * w, kThesisGamma * w);
  }
  Record record{estimation::inverse_real_fft(bins, kThesisSamples), 1, kThesisW0, kThesisGamma};
  add_noise(random, record.displacement, largest(record.displacement) / 20);
  return record;
}

// The same oscillator, but the record is cut from a longer one under white force, so that it does not close on itself.
Record thesis_cut(std::uint64_t seed) {
  GaussianSource random(seed);
  std::vector<double> force(4 * 4 * kThesisSamples);
  for (double& value : force) value = random.normal();
  const auto position = testing::oscillator_response(force, 0.25, kThesisW0, kThesisGamma);
  Record record{{}, 1, kThesisW0, kThesisGamma};
  const std::size_t begin = 4 * kThesisSamples - 100 - kThesisSamples;
  for (std::size_t i = 0; i < kThesisSamples; ++i) record.displacement.push_back(position[(begin + i) * 4]);
  add_noise(random, record.displacement, largest(record.displacement) / 20);
  return record;
}

// The thesis's tree: 1047 frames at 6 Hz, 89 periods, under von Karman wind of 4 m/s.
Record tree(std::uint64_t seed, double damping_ratio) {
  constexpr std::size_t kSamples = 1047;
  constexpr std::size_t kRunUp = 300;
  constexpr std::size_t kOversampling = 5;
  Record record;
  record.sample_period_s = 1.0 / 6;
  record.w0_rad_s = 2 * pi * 89 / (kSamples * record.sample_period_s);
  record.gamma_per_s =
      damping_ratio > 0 ? 2 * damping_ratio * record.w0_rad_s : 2 * pi * 14 / (kSamples * record.sample_period_s);
  GaussianSource random(seed);
  const double fine_period_s = record.sample_period_s / kOversampling;
  auto force = testing::von_karman_wind(random, (kSamples + kRunUp) * kOversampling, fine_period_s);
  for (double& value : force) value *= std::abs(value);
  const auto position = testing::oscillator_response(force, fine_period_s, record.w0_rad_s, record.gamma_per_s);
  double mean = 0;
  for (std::size_t i = 0; i < kSamples; ++i) {
    record.displacement.push_back(position[(kRunUp + i) * kOversampling]);
    mean += record.displacement.back() / kSamples;
  }
  double furthest = 0;
  for (const double value : record.displacement) furthest = std::max(furthest, std::abs(value - mean));
  add_noise(random, record.displacement, furthest / 20);
  return record;
}

struct Scenario {
  std::string name;
  std::function<Record(std::uint64_t)> make;
  IdentifyOptions options;
};

std::vector<Scenario> scenarios() {
  IdentifyOptions thesis;
  thesis.min_frequency_hz = 12.0 / 513;
  thesis.max_frequency_hz = 80.0 / 513;
  thesis.fit_low = 0.2;
  thesis.fit_high = 8;
  thesis.force_slope = 0;
  thesis.force_slope_sd = 0;
  IdentifyOptions wind;
  wind.min_frequency_hz = 0.25;
  wind.max_frequency_hz = 1.2;
  return {{"thesis_gaussian", thesis_periodic, thesis},
          {"thesis_gaussian_cut", thesis_cut, thesis},
          {"tree_zeta_079", [](std::uint64_t seed) { return tree(seed, 0); }, wind},
          {"tree_zeta_030", [](std::uint64_t seed) { return tree(seed, 0.03); }, wind}};
}

}  // namespace

Result<nlohmann::ordered_json> run_identify() {
  nlohmann::ordered_json figures;
  figures["case"] = "identify";
  figures["seeds"] = kSeeds;
  double worst = 0;
  for (const Scenario& scenario : scenarios()) {
    double frequency_square = 0;
    double gamma_square = 0;
    double gamma_sum = 0;
    double floor_frequency = 0;
    double floor_gamma = 0;
    double milliseconds = 0;
    int accepted = 0;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      const Record record = scenario.make(10000 + seed);
      const double begin_s = thread_cpu_seconds();
      const auto fit = estimation::identify(record.displacement, record.sample_period_s, scenario.options);
      milliseconds += 1e3 * (thread_cpu_seconds() - begin_s);
      if (!fit) return fit.error().with_context(scenario.name);
      const double frequency_error = 2 * pi * fit->natural_frequency_hz / record.w0_rad_s - 1;
      const double gamma_error = fit->gamma_per_s / record.gamma_per_s - 1;
      frequency_square += frequency_error * frequency_error / kSeeds;
      gamma_square += gamma_error * gamma_error / kSeeds;
      gamma_sum += gamma_error / kSeeds;
      accepted += fit->accepted ? 1 : 0;
      const double duration_s = static_cast<double>(record.displacement.size()) * record.sample_period_s;
      floor_frequency = std::sqrt(record.gamma_per_s / (2 * duration_s)) / record.w0_rad_s;
      floor_gamma = std::sqrt(2 / (record.gamma_per_s * duration_s));
    }
    const double frequency_rms = std::sqrt(frequency_square);
    const double gamma_rms = std::sqrt(gamma_square);
    const std::string& name = scenario.name;
    figures[name + "_frequency_rms_percent"] = 100 * frequency_rms;
    figures["floor_" + name + "_frequency_rms_percent"] = 100 * floor_frequency;
    figures[name + "_frequency_multiple_of_floor"] = frequency_rms / floor_frequency;
    figures[name + "_gamma_rms_percent"] = 100 * gamma_rms;
    figures["floor_" + name + "_gamma_rms_percent"] = 100 * floor_gamma;
    figures[name + "_gamma_multiple_of_floor"] = gamma_rms / floor_gamma;
    figures[name + "_gamma_bias_percent"] = 100 * gamma_sum;
    figures[name + "_accepted_share"] = static_cast<double>(accepted) / kSeeds;
    figures[name + "_identification_ms"] = milliseconds / kSeeds;
    worst = std::max({worst, frequency_rms / floor_frequency, gamma_rms / floor_gamma});
  }
  figures["worst_multiple_of_floor"] = worst;
  return figures;
}

void add_estimation_cases(std::vector<Case>& cases) {
  cases.push_back({"identify", "natural frequency and damping under random force, as multiples of their floors", run_identify});
  cases.push_back({"online", "wind at a lag of 0 to 2 s from 27 simulated targets, beside the batch smoother", run_online});
}

}  // namespace roseau::bench
