#include "estimation/free_decay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/data.h"
#include "tests/support/sway_simulation.h"

namespace roseau::estimation {
namespace {

using std::numbers::pi;

struct DecayOptions {
  double frequency_hz = 0.24;
  double damping_ratio = 0.04;
  double rate_hz = 4;
  double duration_s = 100;
  double amplitude = 1;
  double offset = 0.2;
  double drift_per_s = 0.001;
  double hold_s = 0;  // pulled and held before the release
};

std::vector<double> free_decay(const DecayOptions& options) {
  std::vector<double> series;
  const double w0 = 2 * pi * options.frequency_hz;
  const double damped = w0 * std::sqrt(1 - options.damping_ratio * options.damping_ratio);
  for (int i = 0; i < static_cast<int>(options.duration_s * options.rate_hz); ++i) {
    const double t = i / options.rate_hz - options.hold_s;
    const double sway = t <= 0 ? 1 : std::exp(-options.damping_ratio * w0 * t) * std::cos(damped * t);
    series.push_back(options.amplitude * sway + options.offset + options.drift_per_s * t);
  }
  return series;
}

TEST(FreeDecay, FindsTheExactOscillatorWithoutNoise) {
  const auto fit = fit_free_decay(free_decay({}), 4, {0.1, 0.5});
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->natural_frequency_hz, 0.24, 1e-6);
  EXPECT_NEAR(fit->damping_ratio, 0.04, 1e-5);
  EXPECT_NEAR(fit->amplitude, std::exp(-0.04 * 2 * pi * 0.24 * fit->start_s), 1e-3);
  EXPECT_LT(fit->start_s, 0.5);
  EXPECT_NEAR(fit->explained, 1, 1e-6);
  EXPECT_LT(fit->natural_frequency_sd_hz, 1e-5);
  EXPECT_DOUBLE_EQ(fit->resolution_hz, 0.01);
  EXPECT_NEAR(fit->spectral_peak_hz, 0.24, fit->resolution_hz);
}

TEST(FreeDecay, BeginsAtTheEndOfTheHold) {
  DecayOptions options;
  options.hold_s = 12;
  const auto fit = fit_free_decay(free_decay(options), 4, {0.1, 0.5});
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->start_s, 12, 0.6);
  EXPECT_NEAR(fit->natural_frequency_hz, 0.24, 1e-4);
  EXPECT_NEAR(fit->damping_ratio, 0.04, 1e-3);
}

TEST(FreeDecay, LeavesOutAFirstSwingThatIsNotYetTheDecay) {
  auto series = free_decay({});
  // The rope comes off slowly: a large one-sided push during the first three seconds.
  for (int i = 0; i < 12; ++i) series[static_cast<std::size_t>(i)] += 8 * std::exp(-i / 3.0);
  const auto fit = fit_free_decay(series, 4, {0.1, 0.5});
  ASSERT_TRUE(fit);
  EXPECT_GT(fit->start_s, 1);
  EXPECT_NEAR(fit->natural_frequency_hz, 0.24, 0.004);
  EXPECT_NEAR(fit->damping_ratio, 0.04, 0.01);
}

TEST(FreeDecay, FastSamplingIsDecimatedAndSaysTheSame) {
  DecayOptions options;
  options.rate_hz = 200;
  options.duration_s = 60.1;
  const auto fit = fit_free_decay(free_decay(options), 200, {0.1, 0.5});
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->natural_frequency_hz, 0.24, 1e-4);
  EXPECT_NEAR(fit->damping_ratio, 0.04, 1e-3);
}

// The reported standard deviations against the scatter of many tests whose noise is wind sway: it has
// its power round the resonance, where white-noise formulae would be far too small.
TEST(FreeDecay, StandardDeviationsCoverColouredResiduals) {
  constexpr int kTests = 100;
  double frequency = 0;
  double damping = 0;
  for (int test = 0; test < kTests; ++test) {
    testing::GaussianSource random(900 + static_cast<std::uint64_t>(test));
    auto series = free_decay({});
    double last = 0;
    double before = 0;
    for (double& value : series) {
      const double sway = 1.77 * last - 0.9 * before + 0.01 * random.normal();  // resonates at 0.24 Hz
      before = std::exchange(last, sway);
      value += sway;
    }
    const auto fit = fit_free_decay(series, 4, {0.1, 0.5});
    ASSERT_TRUE(fit);
    frequency += std::pow((fit->natural_frequency_hz - 0.24) / fit->natural_frequency_sd_hz, 2) / kTests;
    damping += std::pow((fit->damping_ratio - 0.04) / fit->damping_ratio_sd, 2) / kTests;
  }
  EXPECT_GT(std::sqrt(frequency), 0.5);
  EXPECT_LT(std::sqrt(frequency), 1.3);
  EXPECT_GT(std::sqrt(damping), 0.5);
  EXPECT_LT(std::sqrt(damping), 1.3);
}

TEST(FreeDecay, TheBandChoosesTheMode) {
  auto series = free_decay({});
  DecayOptions second;
  second.frequency_hz = 0.9;
  second.damping_ratio = 0.01;
  second.amplitude = 0.5;
  second.offset = 0;
  second.drift_per_s = 0;
  const auto higher = free_decay(second);
  for (std::size_t i = 0; i < series.size(); ++i) series[i] += higher[i];
  const auto low = fit_free_decay(series, 4, {0.1, 0.5});
  const auto high = fit_free_decay(series, 4, {0.6, 1.5});
  ASSERT_TRUE(low && high);
  EXPECT_NEAR(low->natural_frequency_hz, 0.24, 0.002);
  EXPECT_NEAR(high->natural_frequency_hz, 0.9, 0.002);
  EXPECT_NEAR(high->damping_ratio, 0.01, 0.003);
}

TEST(FreeDecay, SaysWhatIsWrongWithItsInput) {
  const auto message = [](const std::vector<double>& series, double rate_hz, FrequencyBand band) {
    const auto fit = fit_free_decay(series, rate_hz, band);
    return fit ? std::string("fitted") : fit.error().message;
  };
  using ::testing::HasSubstr;
  const auto good = free_decay({});
  EXPECT_THAT(message(good, 4, {0.5, 0.1}), HasSubstr("empty"));
  EXPECT_THAT(message(good, 4, {0.1, 3}), HasSubstr("below 2 Hz"));
  EXPECT_THAT(message(good, 0, {0.1, 0.5}), HasSubstr("rate"));
  EXPECT_THAT(message({}, 4, {0.1, 0.5}), HasSubstr("only 0 samples"));
  EXPECT_THAT(message({1, 2, 3}, 4, {0.1, 0.5}), HasSubstr("at least 16 samples"));
  EXPECT_THAT(message(std::vector<double>(400, 7.0), 4, {0.1, 0.5}), HasSubstr("does not move"));
  auto holed = good;
  holed[5] = std::numeric_limits<double>::infinity();
  EXPECT_THAT(message(holed, 4, {0.1, 0.5}), HasSubstr("not finite"));
}

// Twelve pull-and-release tests of two real trees; the expected peaks are those stated with the data.
TEST(FreeDecay, RealTreesSwayAtTheStatedSpectralPeaks) {
  ROSEAU_REQUIRE_DATA(folder, "data/tree_pull_release");
  struct Expected {
    const char* file;
    double low_hz;
    double high_hz;
  };
  const Expected expected[] = {
      {"T14_P1_winter.txt", 0.241, 0.241}, {"T14_P2_winter.txt", 0.241, 0.241}, {"T14_P3_winter.txt", 0.202, 0.202},
      {"T14_P4_winter.txt", 0.202, 0.202}, {"T14_P1_summer.txt", 0.16, 0.19},   {"T14_P2_summer.txt", 0.16, 0.19},
      {"T14_P3_summer.txt", 0.16, 0.19},   {"T16_P1_winter.txt", 0.28, 0.32},   {"T16_P2_winter.txt", 0.28, 0.32},
      {"T16_P1_summer.txt", 0.23, 0.26},   {"T16_P2_summer.txt", 0.23, 0.26},   {"T16_P3_summer.txt", 0.23, 0.26},
  };
  for (const Expected& tree : expected) {
    std::ifstream file(folder / tree.file);
    ASSERT_TRUE(file) << tree.file;
    std::vector<double> strain;
    for (double value = 0; file >> value;) strain.push_back(value);
    const auto fit = fit_free_decay(strain, 4, {0.1, 0.5});  // one band for all trees and seasons
    ASSERT_TRUE(fit) << tree.file;
    EXPECT_GT(fit->natural_frequency_hz, tree.low_hz - fit->resolution_hz) << tree.file;
    EXPECT_LT(fit->natural_frequency_hz, tree.high_hz + fit->resolution_hz) << tree.file;
    EXPECT_NEAR(fit->natural_frequency_hz, fit->spectral_peak_hz, fit->resolution_hz) << tree.file;
    EXPECT_GT(fit->damping_ratio, 0.01) << tree.file;
    EXPECT_LT(fit->damping_ratio, 0.12) << tree.file;
    EXPECT_GT(fit->natural_frequency_sd_hz, 0) << tree.file;
    EXPECT_LT(fit->natural_frequency_sd_hz, fit->resolution_hz) << tree.file;
    EXPECT_LT(fit->damping_ratio_sd, fit->damping_ratio) << tree.file;
  }
}

}  // namespace
}  // namespace roseau::estimation
