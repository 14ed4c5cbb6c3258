#include "estimation/fourier.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "estimation/multitaper.h"
#include "estimation/nelder_mead.h"
#include "tests/support/sway_simulation.h"

namespace roseau::estimation {
namespace {

using std::numbers::pi;

std::vector<double> noise(std::size_t count, std::uint64_t seed, double sd = 1) {
  testing::GaussianSource random(seed);
  std::vector<double> series(count);
  for (double& value : series) value = sd * random.normal();
  return series;
}

TEST(Fourier, EqualsTheSumThatDefinesIt) {
  for (const std::size_t n : {8U, 15U, 31U, 64U}) {
    const auto series = noise(n, n);
    const auto bins = real_fft(series);
    ASSERT_EQ(bins.size(), n / 2 + 1);
    for (std::size_t i = 0; i < bins.size(); ++i) {
      std::complex<double> sum = 0;
      for (std::size_t t = 0; t < n; ++t) {
        sum += series[t] * std::polar(1.0, -2 * pi * static_cast<double>(i * t) / static_cast<double>(n));
      }
      EXPECT_NEAR(std::abs(bins[i] - sum), 0, 1e-12 * static_cast<double>(n)) << n << " bin " << i;
    }
  }
}

TEST(Fourier, InverseGivesTheSeriesBack) {
  for (const std::size_t n : {8U, 513U, 1047U}) {
    const auto series = noise(n, n);
    const auto back = inverse_real_fft(real_fft(series), n);
    for (std::size_t t = 0; t < n; ++t) ASSERT_NEAR(back[t], series[t], 1e-12);
  }
}

TEST(Fourier, FastLengthsHaveSmallFactors) {
  EXPECT_EQ(fast_length_at_most(1047), 1029U);  // 3 * 7^3
  EXPECT_EQ(fast_length_at_least(1047), 1050U);
  EXPECT_EQ(fast_length_at_most(1), 1U);
  EXPECT_EQ(fast_length_at_least(0), 1U);
}

TEST(Multitaper, WhiteNoiseIsFlatAtItsVariance) {
  double mean = 0;
  double low = 0;
  constexpr int kRecords = 200;
  for (int record = 0; record < kRecords; ++record) {
    const auto spectrum = multitaper_spectrum(noise(256, 77 + static_cast<std::uint64_t>(record), 3), 0.1);
    for (std::size_t i = 8; i < 120; ++i) mean += spectrum.power[i] / (112 * kRecords);
    for (std::size_t i = 8; i < 20; ++i) low += spectrum.power[i] / (12 * kRecords);
    ASSERT_DOUBLE_EQ(spectrum.density(9), 2 * 0.1 * spectrum.power[9]);
  }
  EXPECT_NEAR(mean, 9, 0.2);
  EXPECT_NEAR(low, 9, 0.4);
}

TEST(Multitaper, OneLineLooksLikeTheTaperWindow) {
  constexpr std::size_t kSamples = 200;
  std::vector<double> line(kSamples);
  for (std::size_t t = 0; t < kSamples; ++t) line[t] = std::cos(2 * pi * 50 * static_cast<double>(t) / kSamples);
  const auto spectrum = multitaper_spectrum(line, 1);
  const auto window = taper_window(kSamples, 6, 4);
  ASSERT_EQ(window.size(), 49U);
  double total = 0;
  for (const double value : window) total += value;
  EXPECT_NEAR(total, 1, 1e-12);
  for (int offset = -5; offset <= 5; ++offset) {
    const double expected = window[static_cast<std::size_t>(offset + 6) * 4] / window[7 * 4];
    EXPECT_NEAR(spectrum.power[static_cast<std::size_t>(50 + offset)] / spectrum.power[51], expected, 2e-4) << offset;
  }
}

TEST(Multitaper, DecimationKeepsTheNewestAndItsGainIsTheBoxcars) {
  const std::vector<double> series = {100, 1, 2, 3, 4, 5, 6};
  EXPECT_EQ(decimate(series, 3), (std::vector<double>{2, 5}));
  EXPECT_EQ(decimate(series, 1), series);

  constexpr std::size_t kFactor = 5;
  const double per_input_sample = 0.3;
  std::complex<double> sum = 0;
  for (std::size_t i = 0; i < kFactor; ++i) sum += std::polar(0.2, per_input_sample * static_cast<double>(i));
  EXPECT_NEAR(decimation_power_gain(kFactor, kFactor * per_input_sample), std::norm(sum), 1e-12);
  EXPECT_EQ(decimation_power_gain(kFactor, 0), 1);
}

TEST(Multitaper, DetrendLeavesNothingOfALine) {
  std::vector<double> series(50);
  for (std::size_t t = 0; t < series.size(); ++t) series[t] = 3 - 0.25 * static_cast<double>(t);
  for (const double value : detrend(series)) EXPECT_NEAR(value, 0, 1e-12);
}

TEST(Simplex, FindsTheBottomOfRosenbrocksValley) {
  const auto valley = [](std::span<const double> x) { return 100 * std::pow(x[1] - x[0] * x[0], 2) + std::pow(1 - x[0], 2); };
  const double start[] = {-1.2, 1};
  const double steps[] = {0.5, 0.5};
  SimplexOptions options;
  options.parameter_tolerance = 1e-8;
  options.value_tolerance = 1e-14;
  const auto found = minimise_simplex(valley, start, steps, options);
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(found.parameters[0], 1, 1e-6);
  EXPECT_NEAR(found.parameters[1], 1, 1e-6);
  const auto again = minimise_simplex(valley, start, steps, options);
  EXPECT_EQ(found.parameters, again.parameters);
  options.max_evaluations = 20;
  const auto stopped = minimise_simplex(valley, start, steps, options);
  EXPECT_FALSE(stopped.converged);
  EXPECT_LE(stopped.evaluations, 24);
}

}  // namespace
}  // namespace roseau::estimation
