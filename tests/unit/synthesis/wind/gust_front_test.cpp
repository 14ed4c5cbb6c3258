#include "synthesis/wind/gust_front.h"

#include <gtest/gtest.h>

#include <cmath>

namespace roseau::synthesis {
namespace {

// From the south-west at 5 m/s, 20 m long: passes the origin from 10 s to 14 s.
GustFront gust(GustShape shape) {
  return {.shape = shape, .amplitude_mps = 6, .direction_from_deg = 225, .speed_mps = 5, .length_m = 20, .start_s = 10};
}

double speed(const WindField& wind, const Vec3& at, double time_s) {
  const Vec3 air = wind.velocity_mps(at, time_s);
  EXPECT_NEAR(air.x, air.y, 1e-12);  // towards the north-east
  EXPECT_EQ(air.z, 0);
  return (air.x + air.y) / std::sqrt(2);
}

TEST(GustFront, OneMinusCosineRisesAndFalls) {
  const GustFronts wind({gust(GustShape::one_minus_cos)});
  EXPECT_EQ(speed(wind, {}, 9.999), 0);
  EXPECT_NEAR(speed(wind, {}, 11), 3, 1e-12);
  EXPECT_NEAR(speed(wind, {}, 12), 6, 1e-12);
  EXPECT_NEAR(speed(wind, {}, 13), 3, 1e-12);
  EXPECT_EQ(speed(wind, {}, 14.001), 0);
}

TEST(GustFront, RampRisesAndStays) {
  const GustFronts wind({gust(GustShape::ramp)});
  EXPECT_EQ(speed(wind, {}, 9.999), 0);
  EXPECT_NEAR(speed(wind, {}, 12), 3, 1e-12);
  EXPECT_NEAR(speed(wind, {}, 14), 6, 1e-12);
  EXPECT_NEAR(speed(wind, {}, 1000), 6, 1e-12);
}

TEST(GustFront, CrossesTheSiteAtItsSpeedAsAStraightFront) {
  const GustFronts wind({gust(GustShape::one_minus_cos)});
  const double ten_m = 10 / std::sqrt(2);
  for (const double time_s : {10.3, 11.7, 13.2}) {
    const double here = speed(wind, {}, time_s);
    EXPECT_NEAR(speed(wind, {ten_m, ten_m, 4}, time_s + 2), here, 1e-12);  // 10 m downwind, 2 s later
    EXPECT_NEAR(speed(wind, {ten_m, -ten_m, 1}, time_s), here, 1e-12);     // beside
  }
}

TEST(GustFront, SeveralAddUpAndALullTakesAway) {
  GustFront lull = gust(GustShape::ramp);
  lull.amplitude_mps = -2;
  const GustFronts wind({gust(GustShape::ramp), lull});
  EXPECT_NEAR(speed(wind, {}, 20), 4, 1e-12);
}

}  // namespace
}  // namespace roseau::synthesis
