#include "synthesis/wind/recorded_wind.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace roseau::synthesis {
namespace {

constexpr double kRateHz = 20;
const Vec3 kPlace{2, 1, 3};
const WindRegion kAtPlace{.instruments_in_world_m = {kPlace}};

// A minute from the west at 4 m/s, with gusts of whole periods: their mean is zero.
std::vector<Vec3> samples() {
  std::vector<Vec3> made;
  for (double i = 0; i < 1200; ++i) {
    made.push_back({4 + std::sin(0.01 * M_PI * i), 0.5 * std::sin(0.02 * M_PI * i), 0.3 * std::cos(0.03 * M_PI * i)});
  }
  return made;
}

RecordedWindOptions options() { return {.samples_mps = samples(), .rate_hz = kRateHz, .place_in_world_m = kPlace}; }

std::shared_ptr<const RecordedWind> make(const RecordedWindOptions& its, const WindRegion& region = kAtPlace) {
  auto wind = RecordedWind::make(its, region);
  EXPECT_TRUE(wind) << wind.error().message;
  return *wind;
}

TEST(RecordedWind, GivesItsSeriesBackAtItsPlace) {
  const auto wind = make(options());
  const auto series = samples();
  for (std::size_t i = 0; i < series.size(); ++i) {
    const Vec3 air = wind->velocity_mps(kPlace, static_cast<double>(i) / kRateHz);
    ASSERT_NEAR(air.x, series[i].x, 1e-9);
    ASSERT_NEAR(air.y, series[i].y, 1e-9);
    ASSERT_NEAR(air.z, series[i].z, 1e-9);
  }
  // Between samples: the smooth gusts themselves.
  EXPECT_NEAR(wind->velocity_mps(kPlace, 10.025).x, 4 + std::sin(0.01 * M_PI * 200.5), 1e-5);
}

TEST(RecordedWind, ComesLaterDownwindAndIsTheSameBeside) {
  const auto wind = make(options());
  for (const double time_s : {12.0, 31.234}) {
    const Vec3 here = wind->velocity_mps(kPlace, time_s);
    const Vec3 downwind = wind->velocity_mps({kPlace.x + 8, kPlace.y, kPlace.z}, time_s + 2);
    const Vec3 beside = wind->velocity_mps({kPlace.x, kPlace.y + 5, kPlace.z}, time_s);
    EXPECT_NEAR(here.x, downwind.x, 1e-9);
    EXPECT_NEAR(here.z, downwind.z, 1e-9);
    EXPECT_NEAR(here.x, beside.x, 1e-9);
  }
}

TEST(RecordedWind, StartsWhereAsked) {
  auto its = options();
  its.start_s = 7.5;
  EXPECT_NEAR(make(its)->velocity_mps(kPlace, 1).x, make(options())->velocity_mps(kPlace, 8.5).x, 1e-12);
}

TEST(RecordedWind, MeanFollowsTheProfileAndGustsDoNot) {
  auto its = options();
  its.profile_exponent = 0.2;
  const auto wind = make(its);
  const Vec3 here = wind->velocity_mps(kPlace, 20);
  const Vec3 above = wind->velocity_mps({kPlace.x, kPlace.y, 6}, 20);
  EXPECT_NEAR(above.x - here.x, 4 * (std::pow(2, 0.2) - 1), 1e-4);
  EXPECT_NEAR(above.z, here.z, 1e-9);
}

TEST(RecordedWind, TooShortIsRefusedOrLoops) {
  auto its = options();
  const auto refused = RecordedWind::make(its, {.instruments_in_world_m = {kPlace}, .duration_s = 61});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, testing::HasSubstr("lasts 59.95 s"));
  EXPECT_THAT(refused.error().message, testing::HasSubstr("at_end"));
  // 8 m downwind needs the 2 s before the start; 8 m upwind those after the end.
  const auto early = RecordedWind::make(its, {.crown = WindRegion::Box{{9.5, 0, 0}, {10, 1, 1}}, .duration_s = 30});
  ASSERT_FALSE(early);
  EXPECT_THAT(early.error().message, testing::HasSubstr("a start_s from 2.00 to 29.95 would do"));
  EXPECT_FALSE(RecordedWind::make(its, {.crown = WindRegion::Box{{-6, 0, 0}, {-5, 1, 1}}, .duration_s = 58.5}));
  EXPECT_TRUE(RecordedWind::make(its, {.crown = WindRegion::Box{{-6, 0, 0}, {-5, 1, 1}}, .duration_s = 57}));

  its.at_end = RecordingEnd::loop;
  const auto looped = make(its, {.crown = WindRegion::Box{{-6, -1, 0}, {10, 1, 1}}, .duration_s = 1e6});
  const double loop_s = 58;  // without the 2 s that fade
  for (const double time_s : {-3.0, 20.0, 57.99, 1000.0}) {
    EXPECT_NEAR(looped->velocity_mps(kPlace, time_s).x, looped->velocity_mps(kPlace, time_s + loop_s).x, 1e-9);
  }
  for (double time_s = 56; time_s < 62; time_s += 0.05) {  // no jump: slope of the gusts is 0.6 m/s^2 at most
    const double step = looped->velocity_mps(kPlace, time_s + 0.05).x - looped->velocity_mps(kPlace, time_s).x;
    EXPECT_LT(std::abs(step), 0.08) << time_s;
  }
  EXPECT_NEAR(looped->velocity_mps(kPlace, 30).x, samples()[600].x, 1e-9);
}

TEST(RecordedWind, OutsideARecordingTheLastValueStands) {
  const auto wind = make(options());
  EXPECT_NEAR(wind->velocity_mps(kPlace, 1e6).x, samples().back().x, 1e-9);
  EXPECT_NEAR(wind->velocity_mps(kPlace, -1e6).x, samples().front().x, 1e-9);
}

TEST(RecordedWind, BridgesShortHolesAndRefusesLongOnes) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  auto its = options();
  for (std::size_t i = 400; i < 420; ++i) its.samples_mps[i] = {kNan, 0, 0};
  const auto wind = make(its);
  const Vec3 middle = wind->velocity_mps(kPlace, 409.5 / kRateHz);
  EXPECT_NEAR(middle.x, (samples()[399].x + samples()[420].x) / 2, 1e-3);
  for (std::size_t i = 400; i < 441; ++i) its.samples_mps[i] = {kNan, 0, 0};
  const auto refused = RecordedWind::make(its, kAtPlace);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, testing::AllOf(testing::HasSubstr("from 20.0 s"), testing::HasSubstr("2.0 s")));
  its.samples_mps.assign(1200, {kNan, kNan, kNan});
  EXPECT_FALSE(RecordedWind::make(its, kAtPlace));
  its = options();
  its.samples_mps[0] = {kNan, 0, 0};
  its.samples_mps[1199] = {kNan, 0, 0};
  EXPECT_NEAR(make(its)->velocity_mps(kPlace, 0).x, samples()[1].x, 1e-9);
}

TEST(RecordedWind, NeedsAWindThatCarriesIt) {
  auto its = options();
  for (Vec3& sample : its.samples_mps) sample.x -= 4;
  const auto refused = RecordedWind::make(its, kAtPlace);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, testing::HasSubstr("too slow"));
  its.samples_mps.resize(3);
  EXPECT_FALSE(RecordedWind::make(its, kAtPlace));
}

TEST(RecordedWind, TurnsASonicsRecordsIntoTheWorld) {
  for (const double north_offset_deg : {0.0, 72.0}) {
    for (const double from_deg : {10.0, 200.0, 275.0}) {
      const Vec2 uv = wind_components_mps(5, from_deg, north_offset_deg);
      const Vec3 air = velocity_in_world_mps({.u_mps = uv.x, .v_mps = uv.y, .w_mps = 0.3}, north_offset_deg);
      const Vec3 along = towards_from_direction(from_deg);
      EXPECT_NEAR(air.x, 5 * along.x, 1e-9);
      EXPECT_NEAR(air.y, 5 * along.y, 1e-9);
      EXPECT_EQ(air.z, 0.3);
    }
  }
  EXPECT_TRUE(std::isnan(velocity_in_world_mps({.u_mps = 1, .v_mps = 1, .w_mps = 0, .valid = false}, 0).x));
}

}  // namespace
}  // namespace roseau::synthesis
