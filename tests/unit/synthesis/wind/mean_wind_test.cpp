#include "synthesis/wind/mean_wind.h"

#include <gtest/gtest.h>

#include <cmath>

namespace roseau::synthesis {
namespace {

TEST(MeanProfile, TableFollowsTheFormulas) {
  const MeanProfile power({.reference_height_m = 3, .exponent = 0.22});
  const MeanProfile logarithmic(
      {.shape = ProfileShape::logarithmic, .reference_height_m = 10, .roughness_length_m = 0.04, .displacement_height_m = 1.5});
  for (double height = 0.11; height < 900; height *= 1.0037) {
    EXPECT_NEAR(power.ratio(height), std::pow(height / 3, 0.22), 4e-6) << height;
    const double wanted = height > 1.54 ? std::log((height - 1.5) / 0.04) / std::log(8.5 / 0.04) : 0;
    EXPECT_NEAR(logarithmic.ratio(height), wanted, 4e-6) << height;
  }
  EXPECT_NEAR(power.ratio(3), 1, 2e-6);
  EXPECT_NEAR(logarithmic.ratio(10), 1, 2e-6);
  EXPECT_EQ(logarithmic.ratio(-5), 0);
  EXPECT_EQ(power.ratio(-5), power.ratio(0.1));
  EXPECT_EQ(power.ratio(1e9), power.ratio(1024));
  EXPECT_EQ(MeanProfile({.shape = ProfileShape::uniform, .exponent = 0.3}).ratio(0.5), 1);
}

TEST(MeanWind, BlowsAwayFromItsDirection) {
  EXPECT_NEAR(towards_from_direction(270).x, 1, 1e-12);
  EXPECT_NEAR(towards_from_direction(180).y, 1, 1e-12);
  EXPECT_NEAR(towards_from_direction(45).x, -std::sqrt(0.5), 1e-12);
}

}  // namespace
}  // namespace roseau::synthesis
