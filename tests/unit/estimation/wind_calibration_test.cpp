#include "estimation/wind_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "estimation/identify.h"
#include "estimation/latent_force_kalman.h"
#include "estimation/trust_band.h"
#include "tests/support/sway_simulation.h"

namespace roseau::estimation {
namespace {

// A target that leans as V|V|^(n-1) = a u + b says, and an anemometer beside it.
struct Field {
  double gain = 1.7;
  double offset = -3;
  double exponent = 1.6;
  double from_deg = 250;  // the component that pushes the target
  double crosswind_sd = 0.8;
  double delay_s = 0;  // the anemometer feels the gusts later
  double target_noise = 0.05;
  double duration_s = 600;
  double mean_mps = 4;
  std::uint64_t seed = 1;
};

struct Series {
  GridSeries target{3600};
  GridSeries reference{3600};
};

constexpr double kPeriod_s = 0.1;

Series observe(const Field& field) {
  testing::GaussianSource random(field.seed);
  const auto count = static_cast<std::size_t>(field.duration_s / kPeriod_s);
  testing::WindOptions options;
  options.mean_mps = field.mean_mps;
  const auto along = testing::von_karman_wind(random, count, kPeriod_s, options);
  const auto across = testing::von_karman_wind(random, count, kPeriod_s, options);
  Series series;
  for (std::size_t i = 0; i < count; ++i) {
    const auto time = host_time_from_ns(7'000'000'000 + static_cast<std::int64_t>(i) * 100'000'000);
    const double drag = signed_power(along[i], field.exponent);
    series.target.add(time, {(drag - field.offset) / field.gain + field.target_noise * random.normal(), 0});
    const Vec2 main = wind_from_components(along[i], field.from_deg);
    const Vec2 cross = wind_from_components((across[i] - field.mean_mps) * field.crosswind_sd / 1.2, field.from_deg + 90);
    series.reference.add(time + from_seconds(field.delay_s), {main.x + cross.x, main.y + cross.y});
  }
  return series;
}

TEST(WindCalibration, RecoversTheCurveTheDirectionAndTheDelay) {
  for (const double delay_s : {0.0, 1.2, -2.1}) {
    Field field;
    field.delay_s = delay_s;
    const auto series = observe(field);
    const auto fit = calibrate_wind(series.target, series.reference);
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->delay_s, delay_s, 0.3);
    EXPECT_NEAR(fit->direction_deg, 250, 4);
    EXPECT_NEAR(fit->exponent, 1.6, 0.15);
    EXPECT_LT(fit->rms_mps, 0.1);
    EXPECT_GT(fit->correlation, 0.99);
    ASSERT_TRUE(fit->explained);
    EXPECT_GT(*fit->explained, 0.97);
    EXPECT_NEAR(fit->seconds_used, 600, 10);
    // The curve itself, over the winds that blew.
    for (const double wind : {2.0, 4.0, 6.0}) {
      const double lean = (signed_power(wind, field.exponent) - field.offset) / field.gain;
      EXPECT_NEAR(fit->wind_mps(lean), wind, 0.12) << wind;
    }
  }
}

// The whole chain: sway -> identification -> static displacement; calibrated at 4 m/s, used at 6 m/s on the same target.
TEST(WindCalibration, HoldsInAStrongerWindThanItWasMadeIn) {
  for (const double exponent : {2.0, 1.4}) {
    testing::SwayOptions options;
    options.duration_s = 600;
    options.mean_deflection_px = 8;
    options.rest_offset_px = 2;
    options.drag_exponent = exponent;
    testing::SwayOptions stronger = options;
    stronger.wind.mean_mps = 6;
    stronger.mean_deflection_px = 8 * std::pow(1.5, exponent);
    const auto weak_wind = testing::simulate_sway(51, options);
    const auto strong_wind = testing::simulate_sway(951, stronger);
    const auto fit = identify(std::span(weak_wind.displacement_px).first(3600), weak_wind.sample_period_s);
    ASSERT_TRUE(fit);
    const auto observed = [&](const testing::Sway& sway) {
      LatentForceModel model;
      model.natural_frequency_hz = fit->natural_frequency_hz;
      model.damping_ratio = fit->damping_ratio;
      model.sample_period_s = sway.sample_period_s;
      model.noise_sd = fit->noise_sd;
      model.static_mean = 15;
      model.static_sd = 8;
      LatentForceKalman filter(model, 15);
      filter.start(sway.displacement_px[0]);
      std::vector<double> result;
      for (const double x : sway.displacement_px) {
        if (const auto estimate = filter.step(x)) result.push_back(estimate->static_displacement);
      }
      return result;
    };
    const auto weak = observed(weak_wind);
    Series series;
    for (std::size_t i = 0; i < weak.size(); ++i) {
      const auto time = host_time_from_ns(static_cast<std::int64_t>(i) * 33'333'333);
      series.target.add(time, {weak[i], 0});
      series.reference.add(time, wind_from_components(weak_wind.wind_mps[i], 250));
    }
    const auto calibration = calibrate_wind(series.target, series.reference);
    ASSERT_TRUE(calibration);
    EXPECT_NEAR(calibration->exponent, exponent, 0.11);
    std::vector<double> wind;
    for (const double lean : observed(strong_wind)) wind.push_back(calibration->wind_mps(lean));
    const auto slow = [](std::span<const double> values) { return testing::zero_phase_low_pass(values, 1.0 / 30, 0.1); };
    const auto truth = std::span(strong_wind.wind_mps).first(wind.size());
    EXPECT_LT(testing::rms_difference(slow(wind), slow(truth)), 0.15) << exponent;
    EXPECT_GT(testing::correlation(slow(wind), slow(truth)), 0.99) << exponent;
  }
}

TEST(WindCalibration, KeepsTheStatedDirection) {
  const auto series = observe({});
  CalibrationOptions options;
  options.direction_deg = 230;
  const auto fit = calibrate_wind(series.target, series.reference, options);
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->direction_deg, 230);
  options.direction_deg = 70;  // the far side: the same component with the other sign
  const auto opposite = calibrate_wind(series.target, series.reference, options);
  ASSERT_TRUE(opposite);
  EXPECT_LT(opposite->gain, 0);
}

TEST(WindCalibration, WindAgainstTheAxisIsNegative) {
  CalibrationFit fit;
  fit.gain = 2;
  fit.offset = -1;
  fit.exponent = 2;
  EXPECT_DOUBLE_EQ(fit.wind_mps(5), 3);
  EXPECT_DOUBLE_EQ(fit.wind_mps(0.5), 0);
  EXPECT_DOUBLE_EQ(fit.wind_mps(-1.5), -2);
  // Far from still air the spread is that of the slope; in still air it stays finite.
  EXPECT_NEAR(fit.wind_sd_mps(5, 0.03), 2 * 0.03 / (2 * 3), 1e-4);
  EXPECT_GT(fit.wind_sd_mps(0.5, 0.03), 0.1);
  EXPECT_LT(fit.wind_sd_mps(0.5, 0.03), 0.5);
}

TEST(WindCalibration, HeldOutFigureIsNotTheFitsOwn) {
  // An anemometer that has nothing to do with the target: whatever is fitted on one part does not hold on the next.
  Field field;
  field.duration_s = 300;
  const auto series = observe(field);
  field.seed = 2;
  const auto other = observe(field);
  const auto fit = calibrate_wind(series.target, other.reference);
  ASSERT_TRUE(fit);
  ASSERT_TRUE(fit->explained);
  EXPECT_LT(*fit->explained, 0.3);

  field.duration_s = 120;
  const auto brief = observe(field);
  const auto early = calibrate_wind(brief.target, brief.reference);
  ASSERT_TRUE(early);
  EXPECT_FALSE(early->explained);
}

TEST(WindCalibration, KnownRestHoldsTheFootOfTheCurve) {
  // Calibrated in a fresh wind, used in still air.
  double without = 0;
  double with = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Field field;
    field.seed = seed;
    field.mean_mps = 7;
    field.target_noise = 0.5;
    field.duration_s = 240;
    const auto series = observe(field);
    const double rest = -field.offset / field.gain;
    CalibrationOptions options;
    const auto plain = calibrate_wind(series.target, series.reference, options);
    options.rest_displacement = rest;
    const auto held = calibrate_wind(series.target, series.reference, options);
    ASSERT_TRUE(plain && held);
    without += std::abs(plain->wind_mps(rest));
    with += std::abs(held->wind_mps(rest));
  }
  EXPECT_LT(with, 0.5 * without);
}

TEST(WindCalibration, IntervalsHoldTheTruth) {
  int covered = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Field field;
    field.seed = seed;
    field.target_noise = 3;
    CalibrationOptions options;
    options.bootstrap_replicates = 60;
    options.direction_deg = field.from_deg;
    const auto series = observe(field);
    const auto fit = calibrate_wind(series.target, series.reference, options);
    ASSERT_TRUE(fit && fit->exponent_interval && fit->gain_interval && fit->offset_interval);
    EXPECT_LT(fit->gain_interval->low, fit->gain_interval->high);
    if (fit->exponent_interval->low <= field.exponent && field.exponent <= fit->exponent_interval->high) ++covered;
    const auto again = calibrate_wind(series.target, series.reference, options);
    EXPECT_EQ(fit->gain_interval->low, again->gain_interval->low);
  }
  EXPECT_GE(covered, 6);
}

TEST(WindCalibration, GapsInEitherSeriesAreNoSamples) {
  Field field;
  const auto whole = observe(field);
  Series holed;
  for (std::int64_t step = whole.target.first(); step < whole.target.end(); ++step) {
    const auto time = host_time_from_ns(step * GridSeries::kStep_ns);
    if (step % 200 > 60) holed.target.add(time, whole.target.at(step));
    if (step % 170 > 40 && step % 2 == 0) holed.reference.add(time, whole.reference.at(step));
  }
  const auto fit = calibrate_wind(holed.target, holed.reference);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->direction_deg, 250, 5);
  EXPECT_LT(fit->rms_mps, 0.35);
  EXPECT_LT(fit->seconds_used, 520);
}

TEST(WindCalibration, RefusesWhatCannotBeCalibrated) {
  using ::testing::HasSubstr;
  Field field;
  field.duration_s = 20;
  const auto brief = observe(field);
  const auto fit = calibrate_wind(brief.target, brief.reference);
  ASSERT_FALSE(fit);
  EXPECT_THAT(fit.error().message, HasSubstr("share"));
  EXPECT_FALSE(calibrate_wind(GridSeries{3600}, brief.reference));

  Series still;
  for (int i = 0; i < 400; ++i) {
    still.target.add(host_time_from_ns(i * GridSeries::kStep_ns), {3, 0});
    still.reference.add(host_time_from_ns(i * GridSeries::kStep_ns), {1, 1});
  }
  const auto calm = calibrate_wind(still.target, still.reference);
  ASSERT_FALSE(calm);
  EXPECT_THAT(calm.error().message, HasSubstr("does not vary"));
}

TEST(GridSeries, AveragesForgetsAndSurvivesJumps) {
  GridSeries series(10);
  EXPECT_TRUE(std::isnan(series.at(0).x));
  series.add(host_time_from_ns(1'000'000'000), {1, 10});
  series.add(host_time_from_ns(1'400'000'000), {3, 20});
  series.add(host_time_from_ns(2'600'000'000), {5, 30});
  EXPECT_EQ(series.first(), 2);
  EXPECT_EQ(series.end(), 6);
  EXPECT_EQ(series.at(2).x, 2);
  EXPECT_EQ(series.at(2).y, 15);
  EXPECT_TRUE(std::isnan(series.at(3).x));
  EXPECT_EQ(series.at(5).x, 5);
  series.add(host_time_from_ns(0), {100, 100});  // older than all
  series.add(host_time_from_ns(2'600'000'000), {std::nan(""), 0});
  EXPECT_EQ(series.at(5).x, 5);
  for (std::int64_t i = 6; i < 4000; ++i)
    series.add(host_time_from_ns(i * GridSeries::kStep_ns), {1.0 * static_cast<double>(i), 0});
  EXPECT_EQ(series.end(), 4000);
  EXPECT_GT(series.first(), 3000);
  EXPECT_EQ(series.at(3999).x, 3999);
  series.add(host_time_from_ns(std::int64_t{1} << 60), {7, 0});  // a clock that jumped years must not fill memory
  EXPECT_EQ(series.end() - series.first(), 1);
}

OscillatorFit flat_fit() {
  OscillatorFit fit;
  fit.natural_frequency_hz = 1;
  fit.damping_ratio = 0.05;
  fit.noise_sd = 0.2;
  fit.spectrum.samples = 1000;
  fit.spectrum.sample_period_s = 0.1;  // lines 0.01 Hz apart
  fit.spectrum.power.assign(501, 0.04);
  return fit;
}

TEST(TrustBand, IsWhereTheSpectrumStandsAboveTheFloor) {
  OscillatorFit fit = flat_fit();
  EXPECT_TRUE(trust_band(fit).is_empty());
  for (std::size_t line = 40; line <= 180; ++line) fit.spectrum.power[line] = 4;
  const TrustBand band = trust_band(fit);
  EXPECT_NEAR(band.low_hz, 0.40, 0.021);
  EXPECT_NEAR(band.high_hz, 1.80, 0.021);
  EXPECT_TRUE(trust_band(fit, 200).is_empty());
  // One line below the floor does not cut the band: neighbouring lines speak too.
  fit.spectrum.power[150] = 0.01;
  EXPECT_NEAR(trust_band(fit).high_hz, 1.80, 0.021);
  for (std::size_t line = 0; line < 40; ++line) fit.spectrum.power[line] = 4;
  EXPECT_EQ(trust_band(fit).low_hz, 0);
}

TEST(TrustBand, WhiteNoiseInForceIsLeastAtResonance) {
  // VIDA thesis 5.20: S / rho^2. Static end: w0^4 times the displacement's density; resonance: (g w0)^2.
  const double w0 = 2 * std::numbers::pi;
  const double density = 2 * 0.1 * 0.04;
  EXPECT_NEAR(white_noise_force_density(0.2, 0.1, 1, 0.05, 0), density * std::pow(w0, 4), 1e-9);
  EXPECT_NEAR(white_noise_force_density(0.2, 0.1, 1, 0.05, 1), density * std::pow(0.1 * w0 * w0, 2), 1e-9);
  const OscillatorFit fit = flat_fit();
  const ForceSpectrum spectrum = force_spectrum(fit);
  ASSERT_EQ(spectrum.frequency_hz.size(), 500U);
  EXPECT_NEAR(spectrum.frequency_hz[99], 1, 1e-6);
  EXPECT_NEAR(spectrum.force_noise_power[99], density * std::pow(0.1 * w0 * w0, 2), 1e-6);
  EXPECT_NEAR(spectrum.displacement_power[99], density, 1e-6);
  EXPECT_NEAR(spectrum.force_power[9] / spectrum.displacement_power[9], 1 / squared_response(1, 0.05, 0.1), 1e-2);
}

}  // namespace
}  // namespace roseau::estimation
