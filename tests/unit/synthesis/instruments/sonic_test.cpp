#include "synthesis/instruments/sonic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/wind_geometry.h"
#include "tests/unit/synthesis/instruments/simulated_field.h"

namespace roseau::synthesis {
namespace {

SonicOptions quiet() {
  SonicOptions options;
  options.position_in_world_m = {0, 0, 2};
  options.noise_mps = 0;
  options.temperature_noise_celsius = 0;
  options.timing = {};
  return options;
}

std::shared_ptr<const Surroundings> field_of(std::function<Vec3(const Vec3&, double)> wind) {
  auto field = std::make_shared<TestField>();
  field->wind = std::move(wind);
  return field;
}

std::shared_ptr<const Sonic> sonic_of(const SonicOptions& options, std::function<Vec3(const Vec3&, double)> wind) {
  return std::make_shared<Sonic>("sonic", options, 1, field_of(std::move(wind)));
}

TEST(Sonic, EvenWindIsSeenAsItIsWhateverThePaths) {
  for (const double offset_deg : {0.0, 40.0, -120.0}) {
    SonicOptions options = quiet();
    options.north_offset_deg = offset_deg;
    for (const double from_deg : {0.0, 75.0, 200.0, 310.0}) {
      const double from_rad = from_deg * std::numbers::pi / 180;
      const Vec3 air{-5 * std::sin(from_rad), -5 * std::cos(from_rad), 0.7};
      const Vec3 seen = sonic_of(options, [&](const Vec3&, double) { return air; })->path_wind_mps(3);
      const Vec2 expected = wind_components_mps(5, from_deg, offset_deg);
      EXPECT_NEAR(seen.x, expected.x, 1e-12);
      EXPECT_NEAR(seen.y, expected.y, 1e-12);
      EXPECT_NEAR(seen.z, 0.7, 1e-12);
    }
  }
}

TEST(Sonic, PathsAverageWhatVariesAlongThem) {
  // Wind to the east that varies as cos(k z): along a path of length l at 45 degrees z goes from -l sin 45 / 2 to + that, so
  // the mean is sin(a) / a with a = k l sin 45 / 2. Nothing varies in x and y, so all paths see the same.
  SonicOptions options = quiet();
  const double k_per_m = 30;
  const auto sonic = sonic_of(options, [&](const Vec3& point, double) {
    return Vec3{4 * std::cos(k_per_m * (point.z - 2)), 0, 0};
  });
  const double a = k_per_m * 0.15 * std::sqrt(0.5) / 2;
  const Vec3 seen = sonic->path_wind_mps(0);
  EXPECT_NEAR(seen.y, -4 * std::sin(a) / a, 1e-6);  // v > 0 is wind from the east
  EXPECT_NEAR(seen.x, 0, 1e-12);
  EXPECT_NEAR(seen.z, 0, 1e-12);
  options.averages_paths = false;
  EXPECT_NEAR(sonic_of(options,
                       [&](const Vec3& point, double) {
                         return Vec3{4 * std::cos(k_per_m * (point.z - 2)), 0, 0};
                       })
                  ->path_wind_mps(0)
                  .y,
              -4, 1e-12);
}

TEST(Sonic, PathsThatSeeDifferentAirMixUpTheComponents) {
  // Air that rises only on the head's north side: Gill's first path is inclined that way, the others are not.
  const auto sonic = sonic_of(quiet(), [](const Vec3& point, double) { return Vec3{0, 0, 10 * point.y}; });
  const Vec3 seen = sonic->path_wind_mps(0);
  // The field is odd about the middle and every path crosses it there: means vanish.
  EXPECT_NEAR(seen.x, 0, 1e-12);
  EXPECT_NEAR(seen.z, 0, 1e-12);
  const auto even = sonic_of(quiet(), [](const Vec3& point, double) { return Vec3{0, 0, 100 * point.y * point.y}; });
  const double l = 0.15;
  // Mean of y^2: l^2/12 times the square of the path's northward slope (1/2, 1/8, 1/8).
  const double a1 = std::sqrt(0.5) * 100 * l * l / 12 * 0.5;
  const double a2 = std::sqrt(0.5) * 100 * l * l / 12 * 0.125;
  EXPECT_NEAR(even->path_wind_mps(0).z, (a1 + 2 * a2) / 2.1213, 1e-5);  // Gill: W = (a1 + a2 + a3) / 2.1213
  EXPECT_NEAR(even->path_wind_mps(0).x, (2 * a1 - 2 * a2) / 2.1213, 1e-5);
  EXPECT_NEAR(even->path_wind_mps(0).y, 0, 1e-12);
}

TEST(Sonic, AHeadThatLeansSeesTheWindFromBelow) {
  SonicOptions options = quiet();
  options.tilt_about_v_deg = 5;  // about the west axis: the north side goes down
  const Vec3 seen = sonic_of(options, [](const Vec3&, double) { return Vec3{0, 10, 0}; })->path_wind_mps(0);
  EXPECT_NEAR(seen.x, 10 * std::cos(5 * std::numbers::pi / 180), 1e-12);
  EXPECT_NEAR(seen.y, 0, 1e-12);
  EXPECT_NEAR(seen.z, 10 * std::sin(5 * std::numbers::pi / 180), 1e-12);
  options.tilt_about_v_deg = 0;
  options.tilt_about_u_deg = 3;
  const Vec3 sideways = sonic_of(options, [](const Vec3&, double) { return Vec3{-10, 0, 0}; })->path_wind_mps(0);
  EXPECT_NEAR(sideways.y, 10 * std::cos(3 * std::numbers::pi / 180), 1e-12);
  EXPECT_NEAR(sideways.z, -10 * std::sin(3 * std::numbers::pi / 180), 1e-12);
  const Vec3 level = wind_in_head_axes(options, {-10, 0, 0}, Mounting::level);
  EXPECT_NEAR(level.y, 10, 1e-12);
}

TEST(Sonic, ItsBytesDecodeToTheWindWithItsNoiseAndRounding) {
  SonicOptions options = quiet();
  options.noise_mps = 0.03;
  options.split_probability = 0.2;
  const auto sonic = sonic_of(options, [](const Vec3&, double t) { return Vec3{3 + std::sin(t), 0.5, -0.25}; });
  auto device = make_sonic_device(sonic, 1);
  const auto decoded = play_and_decode(*device, 60);
  ASSERT_EQ(decoded->samples.size(), 1200U);
  EXPECT_EQ(decoded->counters.bad_records, 0U);
  EXPECT_EQ(decoded->counters.skipped_bytes, 0U);
  double error2 = 0;
  for (std::size_t i = 0; i < decoded->samples.size(); ++i) {
    const auto& wind = std::get<WindSample>(decoded->samples[i].payload);
    const double t = 0.05 * static_cast<double>(i);
    error2 += std::pow(wind.v_mps + 3 + std::sin(t), 2) + std::pow(wind.u_mps - 0.5, 2) + std::pow(wind.w_mps + 0.25, 2);
    EXPECT_NEAR(wind.sonic_temperature_celsius, 15 - 0.15 * 0.25, 0.0051);
    EXPECT_NEAR(wind.speed_of_sound_mps, std::sqrt(402.684 * (288.15 - 0.0375)), 0.0051);
    EXPECT_NEAR(to_seconds(decoded->samples[i].header.sample_time - kSceneStart), t, 1e-9);
  }
  EXPECT_NEAR(std::sqrt(error2 / 3600), std::hypot(0.03, 0.01 / std::sqrt(12.0)), 0.001);
}

TEST(Sonic, FaultsComeAsOftenAsAskedAndWithoutValues) {
  SonicOptions options = quiet();
  options.fault_probability = 0.05;
  options.marginal_probability = 0.1;
  options.fault_intervals_s = {100, 110};
  auto device = make_sonic_device(sonic_of(options, [](const Vec3&, double) { return Vec3{3, 0, 0}; }), 1);
  const auto decoded = play_and_decode(*device, 600);
  int faults = 0;
  int marginal = 0;
  for (const Sample& sample : decoded->samples) {
    const auto& wind = std::get<WindSample>(sample.payload);
    const double t = to_seconds(sample.header.sample_time - kSceneStart);
    if (t > 99.99 && t < 109.99) {
      EXPECT_EQ(wind.device_status, 7);
      EXPECT_FALSE(wind.valid);
      continue;
    }
    if (!wind.valid) {
      ++faults;
      EXPECT_TRUE(std::isnan(wind.u_mps));
      EXPECT_GE(wind.device_status, 1);
      EXPECT_LE(wind.device_status, 6);
      EXPECT_EQ(sample.header.status, kStatusDeviceError);
    } else if (wind.device_status != 0) {
      ++marginal;
      EXPECT_NEAR(wind.v_mps, -3, 0.01);
    }
  }
  EXPECT_NEAR(faults, 0.05 * 11800, 90);
  EXPECT_NEAR(marginal, 0.1 * 11800, 120);
  EXPECT_EQ(decoded->counters.bad_records, 0U) << "a fault is a good record";
}

TEST(Sonic, AStormBeyondItsRangeIsNotMeasured) {
  const auto sonic = sonic_of(quiet(), [](const Vec3&, double t) { return Vec3{t < 1 ? 49.0 : 51.0, 0, 0}; });
  EXPECT_TRUE(sonic->measure(0).valid);
  EXPECT_FALSE(sonic->measure(30).valid);
  EXPECT_EQ(sonic->measure(30).device_status, 7);
}

TEST(Sonic, BytesThatErrAreBadRecordsOrSkipped) {
  SonicOptions options = quiet();
  options.byte_error_probability = 0.001;  // about one record in twenty
  auto device = make_sonic_device(sonic_of(options, [](const Vec3&, double) { return Vec3{3, 1, 0}; }), 1);
  const auto decoded = play_and_decode(*device, 600);
  EXPECT_NEAR(static_cast<double>(decoded->samples.size()), 12000 * std::pow(0.999, 51), 60);
  EXPECT_GT(decoded->counters.bad_records, 300U);
  for (const Sample& sample : decoded->samples) EXPECT_NEAR(std::get<WindSample>(sample.payload).u_mps, 1, 0.0051);
}

}  // namespace
}  // namespace roseau::synthesis
