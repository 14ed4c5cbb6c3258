#include "estimation/identify.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>

#include "estimation/fourier.h"
#include "tests/support/sway_simulation.h"

namespace roseau::estimation {
namespace {

using std::numbers::pi;
using testing::GaussianSource;
using testing::SwayOptions;

// The oscillator of VIDA thesis 5.6 driven by a force of unit amplitude in every line, made with a generator that can be
// written in one line in any language. The expected values come from an independent program.
struct PortableVector {
  static constexpr std::size_t kSamples = 513;
  std::vector<double> phases;
  std::vector<double> clean;
  std::vector<double> deviates;
  std::vector<double> noisy;
  double noise_sd = 0;

  PortableVector() {
    testing::PortableRandom random(12345);
    const double w0 = 2 * pi * 30 / kSamples;
    const double gamma = 2 * pi * 10 / kSamples;
    std::vector<std::complex<double>> bins;
    for (std::size_t i = 0; i <= kSamples / 2; ++i) {
      phases.push_back(i == 0 ? 0 : 2 * pi * random.uniform());
      const double w = 2 * pi * static_cast<double>(i) / kSamples;
      bins.push_back(std::polar(1.0, phases.back()) / std::complex<double>(w0 * w0 - w * w, gamma * w));
    }
    clean = inverse_real_fft(bins, kSamples);
    double largest = 0;
    for (const double value : clean) largest = std::max(largest, std::abs(value));
    noise_sd = largest / 20;
    for (const double value : clean) {
      const double radius = std::sqrt(-2 * std::log(random.uniform()));
      deviates.push_back(radius * std::cos(2 * pi * random.uniform()));
      noisy.push_back(value + noise_sd * deviates.back());
    }
  }
};

// VIDA thesis 5.3.3: the peak of |X|^2, and the width at half its height, both in lines.
struct HalfPower {
  double peak = 0;
  double width = 0;
};

HalfPower half_power(const std::vector<double>& series) {
  std::vector<double> power;
  for (const auto& bin : real_fft(series)) power.push_back(std::norm(bin));
  std::size_t peak = 1;
  for (std::size_t i = 1; i < power.size(); ++i) peak = power[i] > power[peak] ? i : peak;
  const double half = power[peak] / 2;
  std::size_t low = peak;
  while (low > 0 && power[low] >= half) --low;
  std::size_t high = peak;
  while (high + 1 < power.size() && power[high] >= half) ++high;
  const double left = static_cast<double>(low) + (half - power[low]) / (power[low + 1] - power[low]);
  const double right = static_cast<double>(high) - (half - power[high]) / (power[high - 1] - power[high]);
  return {static_cast<double>(peak), right - left};
}

IdentifyOptions thesis_options() {
  IdentifyOptions options;
  options.min_frequency_hz = 12.0 / 513;
  options.max_frequency_hz = 80.0 / 513;
  options.fit_low = 0.2;
  options.fit_high = 8;
  options.force_slope = 0;
  options.force_slope_sd = 0;
  return options;
}

TEST(PortableVector, IsTheOneOtherProgramsHave) {
  const PortableVector vector;
  EXPECT_NEAR(vector.phases[1], 4.11645429, 1e-8);
  EXPECT_NEAR(vector.phases[3], 4.24090274, 1e-8);
  EXPECT_NEAR(vector.clean[0], -0.27192449, 1e-8);
  EXPECT_NEAR(vector.clean[3], -0.19125038, 1e-8);
  EXPECT_NEAR(vector.noise_sd, 0.036393899, 1e-9);
  EXPECT_NEAR(vector.deviates[0], 2.8474187, 1e-7);
  EXPECT_NEAR(vector.noisy[2], -0.15966783, 1e-8);
}

TEST(Identify, PortableVectorAgreesWithAnIndependentProgram) {
  const PortableVector vector;
  const auto fit = identify(vector.noisy, 1, thesis_options());
  ASSERT_TRUE(fit);
  // An independent multitaper Whittle fit with the same tapers: 30.0192 and 9.1848 cycles per record, noise 0.036507.
  EXPECT_NEAR(fit->natural_frequency_hz * 513, 30.0192, 0.02);
  EXPECT_NEAR(fit->gamma_per_s / (2 * pi) * 513, 9.1848, 0.02);
  EXPECT_NEAR(fit->noise_sd, 0.036507, 2e-5);
  EXPECT_TRUE(fit->accepted);
}

// Errata: half power works for the thesis's force of equal amplitude in every line, and measures the width of a single line as
// soon as the force is random.
TEST(Identify, HalfPowerWidthIsOfOneLineUnderARandomForce) {
  const HalfPower flat = half_power(PortableVector().noisy);
  EXPECT_EQ(flat.peak, 28);
  EXPECT_NEAR(flat.width, 10.5188257502, 1e-8);

  constexpr int kSeeds = 40;
  double half_power_bias = 0;
  double fitted_bias = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    GaussianSource random(seed);
    std::vector<std::complex<double>> bins;
    const double w0 = 2 * pi * 30 / 513;
    for (int i = 0; i <= 256; ++i) {
      const double w = 2 * pi * i / 513;
      const double real = random.normal();
      const std::complex<double> force(real, i == 0 ? 0 : random.normal());
      bins.push_back(force / std::complex<double>(w0 * w0 - w * w, w * w0 / 3));
    }
    auto series = inverse_real_fft(bins, 513);
    half_power_bias += (half_power(series).width / 10 - 1) / kSeeds;
    const auto fit = identify(series, 1, thesis_options());
    ASSERT_TRUE(fit);
    fitted_bias += (fit->gamma_per_s / (w0 / 3) - 1) / kSeeds;
  }
  EXPECT_LT(half_power_bias, -0.7);
  EXPECT_NEAR(fitted_bias, 0, 0.12);
}

TEST(Identify, ErrorsStayNearTheFloorOfTheRecord) {
  constexpr int kSeeds = 24;
  SwayOptions options;
  options.duration_s = 180;
  double frequency = 0;
  double damping = 0;
  double noise = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto sway = testing::simulate_sway(seed, options);
    const auto fit = identify(sway.displacement_px, sway.sample_period_s);
    ASSERT_TRUE(fit);
    EXPECT_TRUE(fit->accepted);
    frequency += std::pow((fit->natural_frequency_hz - 1) / fit->natural_frequency_sd_hz, 2) / kSeeds;
    damping += std::pow((fit->damping_ratio - 0.05) / fit->damping_ratio_sd, 2) / kSeeds;
    noise += fit->noise_sd / kSeeds;
  }
  // In units of the standard deviations reported with each estimate.
  EXPECT_LT(std::sqrt(frequency), 2);
  EXPECT_LT(std::sqrt(damping), 2);
  EXPECT_NEAR(noise, options.noise_px, 0.1 * options.noise_px);
}

TEST(Identify, StandardDeviationsAreTheTwoFloors) {
  const auto sway = testing::simulate_sway(3, SwayOptions{});
  const auto fit = identify(sway.displacement_px, sway.sample_period_s);
  ASSERT_TRUE(fit);
  const double gamma = fit->gamma_per_s;
  EXPECT_NEAR(gamma, 4 * pi * fit->damping_ratio * fit->natural_frequency_hz, 1e-12);
  EXPECT_NEAR(2 * pi * fit->natural_frequency_sd_hz, std::sqrt(gamma / (2 * fit->duration_s)), 1e-12);
  EXPECT_NEAR(fit->damping_ratio_sd / fit->damping_ratio, std::sqrt(2 / (gamma * fit->duration_s)), 1e-12);
  IdentifyOptions with_prior;
  with_prior.damping_prior = DampingPrior{};
  const auto held = identify(sway.displacement_px, sway.sample_period_s, with_prior);
  ASSERT_TRUE(held);
  EXPECT_LT(held->damping_ratio_sd / held->damping_ratio, fit->damping_ratio_sd / fit->damping_ratio);
}

TEST(Identify, PriorHoldsTheDampingOfAShortRecord) {
  SwayOptions options;
  options.duration_s = 20;
  IdentifyOptions with_prior;
  with_prior.damping_prior = DampingPrior{0.05, 0.3};
  double plain = 0;
  double held = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const auto sway = testing::simulate_sway(seed, options);
    const auto without = identify(sway.displacement_px, sway.sample_period_s);
    const auto with = identify(sway.displacement_px, sway.sample_period_s, with_prior);
    ASSERT_TRUE(without && with);
    plain += std::pow(std::log(without->damping_ratio / 0.05), 2);
    held += std::pow(std::log(with->damping_ratio / 0.05), 2);
  }
  EXPECT_LT(held, 0.6 * plain);
}

TEST(Identify, SlopeOfTheForceMustBeInTheModel) {
  // White-force model on wind data: frequency drawn down and damping up, which is why the slope is fitted.
  IdentifyOptions white = {};
  white.force_slope = 0;
  white.force_slope_sd = 0;
  SwayOptions options;
  options.duration_s = 240;
  options.damping_ratio = 0.1;
  double with_slope = 0;
  double without = 0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const auto sway = testing::simulate_sway(seed, options);
    const auto good = identify(sway.displacement_px, sway.sample_period_s);
    const auto bad = identify(sway.displacement_px, sway.sample_period_s, white);
    ASSERT_TRUE(good && bad);
    with_slope += good->natural_frequency_hz / 8;
    without += bad->natural_frequency_hz / 8;
  }
  EXPECT_NEAR(with_slope, 1, 0.015);
  EXPECT_LT(without, 0.96);
}

TEST(Identify, DecimationDoesNotBendTheResult) {
  SwayOptions options;
  options.rate_hz = 240;
  options.duration_s = 90;
  const auto sway = testing::simulate_sway(5, options);
  IdentifyOptions fast;
  fast.min_rate_hz = 60;
  const auto slow_fit = identify(sway.displacement_px, sway.sample_period_s);
  const auto fast_fit = identify(sway.displacement_px, sway.sample_period_s, fast);
  ASSERT_TRUE(slow_fit && fast_fit);
  EXPECT_EQ(slow_fit->decimation, 19U);
  EXPECT_EQ(fast_fit->decimation, 4U);
  EXPECT_NEAR(slow_fit->natural_frequency_hz, fast_fit->natural_frequency_hz, 0.003);
  EXPECT_NEAR(slow_fit->damping_ratio / fast_fit->damping_ratio, 1, 0.1);
  // Under the sway up to three times its frequency this camera's noise hardly shows.
  EXPECT_NEAR(std::log(slow_fit->noise_sd / 0.3), 0, std::log(1.6));
}

TEST(Identify, ModelDensityDescribesTheSpectrumItWasFittedTo) {
  SwayOptions options;
  options.duration_s = 600;
  const auto sway = testing::simulate_sway(9, options);
  const auto fit = identify(sway.displacement_px, sway.sample_period_s);
  ASSERT_TRUE(fit);
  double log_ratio = 0;
  int lines = 0;
  for (std::size_t i = 0; i < fit->spectrum.power.size(); ++i) {
    const double hz = static_cast<double>(i) * fit->spectrum.bin_hz();
    if (hz < 0.5 || hz > 2) continue;
    log_ratio += std::log(fit->spectrum.density(i) / fit->model_density(hz));
    ++lines;
  }
  EXPECT_NEAR(log_ratio / lines, 0, 0.25);  // the logarithm of an average of four looks is low by 0.13
  EXPECT_NEAR(fit->model_density(6), fit->noise_density(), 0.2 * fit->noise_density());
}

TEST(Identify, GateNeverAcceptsAWrongFrequency) {
  int accepted = 0;
  int runs = 0;
  for (const double deflection_px : {0.2, 0.5, 1.0, 3.0}) {
    for (const double damping_ratio : {0.03, 0.1}) {
      for (std::uint64_t seed = 0; seed < 8; ++seed) {
        SwayOptions options;
        options.mean_deflection_px = deflection_px;
        options.damping_ratio = damping_ratio;
        const auto sway = testing::simulate_sway(100 + seed, options);
        const auto fit = identify(sway.displacement_px, sway.sample_period_s);
        ASSERT_TRUE(fit);
        ++runs;
        if (!fit->accepted) continue;
        ++accepted;
        EXPECT_NEAR(fit->natural_frequency_hz, 1, 0.05) << deflection_px << " px, zeta " << damping_ratio << ", seed " << seed;
      }
    }
  }
  EXPECT_GT(accepted, runs * 6 / 10);
  EXPECT_LT(accepted, runs);
}

TEST(Identify, GateIsThePeakOverTheFloor) {
  const auto sway = testing::simulate_sway(3, SwayOptions{});
  const auto fit = identify(sway.displacement_px, sway.sample_period_s);
  ASSERT_TRUE(fit);
  // By definition: the oscillator's part at its natural frequency over the floor.
  const double at_peak = fit->model_density(fit->natural_frequency_hz) - fit->noise_density();
  EXPECT_NEAR(fit->peak_to_floor / (at_peak / fit->noise_density()), 1, 1e-9);
  IdentifyOptions options;
  options.gate = 0.99 * fit->peak_to_floor;
  EXPECT_TRUE(identify(sway.displacement_px, sway.sample_period_s, options)->accepted);
  options.gate = 1.01 * fit->peak_to_floor;
  EXPECT_FALSE(identify(sway.displacement_px, sway.sample_period_s, options)->accepted);
}

TEST(Identify, GateRejectsWhatDoesNotSway) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    GaussianSource random(seed);
    std::vector<double> noise(1800);
    for (double& value : noise) value = 0.2 * random.normal();
    const auto still = identify(noise, 1.0 / 30);
    ASSERT_TRUE(still);
    EXPECT_FALSE(still->accepted) << "white noise, seed " << seed;

    // A tracker that drifts, and a stiff target that follows the gusts without a resonance of its own.
    std::vector<double> drift(1800);
    double position = 0;
    for (double& value : drift) value = (position += 0.05 * random.normal()) + 0.05 * random.normal();
    const auto drifting = identify(drift, 1.0 / 30);
    ASSERT_TRUE(drifting);
    EXPECT_FALSE(drifting->accepted) << "drift, seed " << seed << ", f0 " << drifting->natural_frequency_hz;

    auto wind = testing::von_karman_wind(random, 1800, 1.0 / 30);
    for (double& value : wind) value = 0.3 * value * std::abs(value) + 0.1 * random.normal();
    const auto stiff = identify(wind, 1.0 / 30);
    ASSERT_TRUE(stiff);
    EXPECT_FALSE(stiff->accepted) << "stiff, seed " << seed << ", f0 " << stiff->natural_frequency_hz;
  }
}

TEST(Identify, IsDeterministicAndIndependentOfTheUnit) {
  const auto sway = testing::simulate_sway(1, SwayOptions{});
  const auto first = identify(sway.displacement_px, sway.sample_period_s);
  const auto second = identify(sway.displacement_px, sway.sample_period_s);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->natural_frequency_hz, second->natural_frequency_hz);
  EXPECT_EQ(first->noise_sd, second->noise_sd);

  std::vector<double> strain = sway.displacement_px;
  for (double& value : strain) value *= 1e-6;
  const auto small = identify(strain, sway.sample_period_s);
  ASSERT_TRUE(small);
  EXPECT_NEAR(small->natural_frequency_hz, first->natural_frequency_hz, 1e-3);
  EXPECT_NEAR(small->noise_sd / first->noise_sd, 1e-6, 1e-8);
  EXPECT_EQ(small->accepted, first->accepted);
}

TEST(Identify, RefusesWhatCannotBeIdentified) {
  const auto code = [](const std::vector<double>& series, double period_s) {
    const auto fit = identify(series, period_s);
    return fit ? std::string("accepted") : fit.error().message;
  };
  const auto sway = testing::simulate_sway(1, SwayOptions{});
  EXPECT_THAT(code({}, 1.0 / 30), ::testing::HasSubstr("too few"));
  EXPECT_THAT(code({1, 2, 3}, 1.0 / 30), ::testing::HasSubstr("3 samples"));
  EXPECT_THAT(code({sway.displacement_px.begin(), sway.displacement_px.begin() + 200}, 1.0 / 30),
              ::testing::HasSubstr("too few"));
  EXPECT_THAT(code(std::vector<double>(2000, 4.2), 1.0 / 30), ::testing::HasSubstr("does not move"));
  EXPECT_THAT(code(sway.displacement_px, 0), ::testing::HasSubstr("sample period"));
  EXPECT_THAT(code(sway.displacement_px, std::numeric_limits<double>::quiet_NaN()), ::testing::HasSubstr("sample period"));
  auto holed = sway.displacement_px;
  holed[100] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(code(holed, 1.0 / 30), ::testing::HasSubstr("not finite"));
}

}  // namespace
}  // namespace roseau::estimation
