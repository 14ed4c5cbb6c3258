#include "synthesis/wind/wind_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace roseau::synthesis {
namespace {

using testing::HasSubstr;

const Vec3 kHere{0.2, 0.3, 2.6};
const WindRegion kRegion{.instruments_in_world_m = {kHere}};

Vec3 velocity(const WindOptions& options, const Vec3& at = kHere, double time_s = 5) {
  auto wind = make_wind(options, 1, kRegion);
  EXPECT_TRUE(wind) << wind.error().message;
  return (*wind)->velocity_mps(at, time_s);
}

std::string problem(const WindOptions& options) {
  const auto checked = check(options);
  EXPECT_FALSE(make_wind(options, 1, kRegion));
  return checked ? "" : checked.error().message;
}

TEST(WindOptions, NothingIsCalm) {
  const Vec3 none = velocity({.turbulence = {}});
  EXPECT_EQ(std::hypot(none.x, none.y, none.z), 0);
  const Vec3 still = velocity({.turbulence = TurbulentWindOptions{.mean_speed_mps = 0}});
  EXPECT_EQ(std::hypot(still.x, still.y, still.z), 0);
}

TEST(WindOptions, WithoutIntensityTheWindIsSteady) {
  const WindOptions steady{.turbulence = TurbulentWindOptions{.turbulence_intensity = 0}};
  EXPECT_NEAR(velocity(steady).x, 4, 1e-5);
  EXPECT_EQ(velocity(steady, kHere, 1).x, velocity(steady, kHere, 99).x);
}

TEST(WindOptions, KindsAddUp) {
  WindOptions options;
  const Vec3 turbulence = velocity(options);
  options.primitives = {{.kind = FlowKind::uniform, .velocity_mps = {0, 2, 0}}};
  options.gusts = {{.shape = GustShape::ramp, .amplitude_mps = 3, .direction_from_deg = 270, .start_s = -100}};
  const Vec3 all = velocity(options);
  EXPECT_NEAR(all.x, turbulence.x + 3, 1e-9);
  EXPECT_NEAR(all.y, turbulence.y + 2, 1e-9);
  EXPECT_NEAR(all.z, turbulence.z, 1e-9);
}

TEST(WindOptions, DriftingPrimitivesGoWithTheMeanWind) {
  WindOptions options{.turbulence = TurbulentWindOptions{.turbulence_intensity = 0}};
  options.primitives = {
      {.kind = FlowKind::vortex, .centre_in_world_m = {-20, 0}, .strength_m2ps = 10, .drifts_with_wind = true}};
  EXPECT_NEAR(velocity(options, {0, 0, 2.6}, 5).y, 0, 1e-9);  // at 4 m/s its axis is here after 5 s
  EXPECT_GT(velocity(options, {1, 0, 2.6}, 5).y, 0.5);
  // Without turbulence, the uniform primitives carry it.
  options.turbulence.reset();
  options.primitives.push_back({.kind = FlowKind::uniform, .velocity_mps = {4, 0, 0}});
  EXPECT_NEAR(velocity(options, {0, 0, 2.6}, 5).y, 0, 1e-9);
  EXPECT_NEAR(mean_wind_mps(options).x, 4, 1e-12);
}

TEST(WindOptions, ARecordingTakesThePlaceOfTurbulence) {
  RecordedWindOptions recording{.place_in_world_m = kHere};
  for (double i = 0; i < 400; ++i) recording.samples_mps.push_back({3 + std::sin(i), 0, 0});
  WindOptions options{.turbulence = {}, .recording = recording};
  EXPECT_NEAR(velocity(options, kHere, 5).x, 3 + std::sin(100), 1e-9);
  EXPECT_NEAR(mean_wind_mps(options).x, 3, 0.02);
  options.turbulence.emplace();
  EXPECT_THAT(problem(options), HasSubstr("wind.recording takes the place"));
}

TEST(WindOptions, ProblemsNameTheirKey) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto turbulence = [](const TurbulentWindOptions& options) { return problem({.turbulence = options}); };
  EXPECT_THAT(turbulence({.mean_speed_mps = -1}),
              HasSubstr("wind.mean_speed_mps must be 0 (calm) or between 0.1 and 60, not -1"));
  EXPECT_THAT(turbulence({.mean_speed_mps = kNan}), HasSubstr("wind.mean_speed_mps"));
  EXPECT_THAT(turbulence({.direction_from_deg = 400}), HasSubstr("wind.direction_from_deg"));
  EXPECT_THAT(turbulence({.turbulence_intensity = 2}), HasSubstr("wind.turbulence_intensity"));
  EXPECT_THAT(turbulence({.length_scale_m = 0}), HasSubstr("wind.length_scale_m"));
  EXPECT_THAT(turbulence({.vertical_length_scale_m = -1}), HasSubstr("wind.vertical_length_scale_m"));
  EXPECT_THAT(turbulence({.lateral_decay = 0}), HasSubstr("wind.lateral_decay"));
  EXPECT_THAT(turbulence({.vertical_decay = kNan}), HasSubstr("wind.vertical_decay"));
  EXPECT_THAT(turbulence({.strand_spacing_m = 0}), HasSubstr("wind.strand_spacing_m"));
  EXPECT_THAT(turbulence({.period_s = 1e9}), HasSubstr("wind.period_s"));
  EXPECT_THAT(turbulence({.reference_height_m = 1, .profile = ProfileShape::logarithmic, .displacement_height_m = 2}),
              HasSubstr("wind.reference_height_m must be above displacement_height_m"));
  EXPECT_THAT(problem({.primitives = {{}, {.kind = FlowKind::vortex, .core_radius_m = 0}}}),
              HasSubstr("wind.primitive[1].core_radius_m"));
  EXPECT_THAT(problem({.primitives = {{.velocity_mps = {kNan, 0, 0}}}}), HasSubstr("wind.primitive[0].velocity_mps"));
  EXPECT_THAT(problem({.gusts = {{.speed_mps = 0}}}), HasSubstr("wind.gust[0].speed_mps"));
  EXPECT_THAT(problem({.gusts = {{.length_m = -3}}}), HasSubstr("wind.gust[0].length_m"));
  EXPECT_THAT(problem({.turbulence = {}, .recording = RecordedWindOptions{.rate_hz = 0}}), HasSubstr("wind.recording.rate_hz"));
  EXPECT_TRUE(check(WindOptions{}));
}

TEST(WindOptions, TheSameSeedGivesTheSameWind) {
  const WindOptions options{.turbulence = TurbulentWindOptions{.period_s = 64}};
  const WindRegion region{.crown = WindRegion::Box{{-1, -1, 1}, {1, 1, 3}}, .instruments_in_world_m = {kHere}};
  const auto one = make_wind(options, 1, region);
  const auto same = make_wind(options, 1, region);
  const auto other = make_wind(options, 2, region);
  ASSERT_TRUE(one && same && other);
  const Vec3 between{0.1, 0.15, 2.05};
  EXPECT_EQ((*one)->velocity_mps(between, 5).y, (*same)->velocity_mps(between, 5).y);
  EXPECT_NE((*one)->velocity_mps(between, 5).y, (*other)->velocity_mps(between, 5).y);
}

}  // namespace
}  // namespace roseau::synthesis
