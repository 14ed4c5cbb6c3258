#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "core/wind_geometry.h"
#include "core/wind_statistics.h"
#include "tests/support/data.h"

namespace roseau {
namespace {

TEST(WindDirection, IsWhereTheWindComesFrom) {
  EXPECT_DOUBLE_EQ(wind_direction_deg(1, 0, 0), 180);  // +u: from the south
  EXPECT_DOUBLE_EQ(wind_direction_deg(-1, 0, 0), 0);
  EXPECT_DOUBLE_EQ(wind_direction_deg(0, 1, 0), 90);  // +v: from the east
  EXPECT_DOUBLE_EQ(wind_direction_deg(0, -1, 0), 270);
}

TEST(WindDirection, TurnsWithTheInstrument) {
  EXPECT_DOUBLE_EQ(wind_direction_deg(1, 0, 235), 55);
  EXPECT_DOUBLE_EQ(wind_direction_deg(-1, 0, -10), 350);
}

TEST(WindDirection, AxisConventionIsThirtyDegreesOff) {
  // u_spar = u cos 30 - v sin 30, v_spar = u sin 30 + v cos 30
  const double u = 1.3;
  const double v = -0.4;
  const double c = std::sqrt(0.75);
  const double s = 0.5;
  EXPECT_NEAR(wind_direction_deg(u, v, 12, WindAxes::gill_axis), wind_direction_deg(u * c - v * s, u * s + v * c, 12), 1e-12);
}

TEST(WindDirection, EastAndNorthComponents) {
  // A line of a TriSonica: S2 02.222 D 255 U 02.142 V 00.592
  EXPECT_NEAR(wind_direction_deg(2.142, 0.592, 0, WindAxes::east_north), 255, 0.6);
  EXPECT_NEAR(wind_direction_deg(2.142, 0.592, 20, WindAxes::east_north), 275, 0.6);
  EXPECT_NEAR(wind_direction_deg(0, 1, 0, WindAxes::east_north), 180, 1e-12) << "v > 0: from the south";
}

TEST(WindDirection, StaysBelow360) {
  EXPECT_EQ(wrap_degrees(360), 0);
  EXPECT_EQ(wrap_degrees(-720), 0);
  EXPECT_LT(wrap_degrees(-1e-20), 360);
  EXPECT_DOUBLE_EQ(wrap_degrees(-1), 359);
  EXPECT_DOUBLE_EQ(wrap_degrees(1085), 5);
}

TEST(WindDirection, ComponentsAreItsInverse) {
  for (const auto axes : {WindAxes::gill_spar, WindAxes::gill_axis, WindAxes::east_north}) {
    for (double direction_deg = 0; direction_deg < 360; direction_deg += 11) {
      const Vec2 wind = wind_components_mps(3, direction_deg, 235, axes);
      EXPECT_NEAR(std::hypot(wind.x, wind.y), 3, 1e-12);
      EXPECT_NEAR(std::remainder(wind_direction_deg(wind.x, wind.y, 235, axes) - direction_deg, 360), 0, 1e-9);
    }
  }
}

TEST(WindDirection, AxesHaveNames) {
  for (const auto axes : {WindAxes::gill_spar, WindAxes::gill_axis, WindAxes::east_north}) {
    EXPECT_EQ(*wind_axes_from_string(to_string(axes)), axes);
  }
  EXPECT_FALSE(wind_axes_from_string("young"));
}

TEST(WindStatistics, TheMeansDiffer) {
  WindStatistics statistics;
  statistics.add({.u_mps = 3, .v_mps = 0, .w_mps = 4});
  statistics.add({.u_mps = 0, .v_mps = 1, .w_mps = 0});
  EXPECT_EQ(statistics.samples(), 2U);
  EXPECT_DOUBLE_EQ(statistics.vector_mean_speed_mps(), std::sqrt(1.5 * 1.5 + 0.5 * 0.5 + 2.0 * 2.0));
  EXPECT_DOUBLE_EQ(statistics.scalar_mean_speed_3d_mps(), 3.0);          // (5 + 1) / 2
  EXPECT_DOUBLE_EQ(statistics.scalar_mean_speed_horizontal_mps(), 2.0);  // (3 + 1) / 2
  EXPECT_DOUBLE_EQ(statistics.unit_vector_mean_direction_deg(0), 135);   // south and east alike, whatever their speeds
}

TEST(WindStatistics, TwoDimensionalInstrumentsCount) {
  WindStatistics statistics;
  statistics.add({.u_mps = 3, .v_mps = 4});
  EXPECT_DOUBLE_EQ(statistics.scalar_mean_speed_3d_mps(), 5.0);
  EXPECT_DOUBLE_EQ(statistics.vector_mean_speed_mps(), 5.0);
}

TEST(WindStatistics, BadSamplesAreLeftOutAndCounted) {
  WindStatistics statistics;
  statistics.add({.u_mps = 3, .v_mps = 4, .w_mps = 0, .valid = false});
  statistics.add({});
  EXPECT_EQ(statistics.samples(), 0U);
  EXPECT_EQ(statistics.left_out(), 2U);
  EXPECT_TRUE(std::isnan(statistics.vector_mean_speed_mps()));
  EXPECT_TRUE(std::isnan(statistics.unit_vector_mean_direction_deg(0)));
}

TEST(WindStatistics, CalmHasNoDirection) {
  WindStatistics statistics;
  statistics.add({.u_mps = 0, .v_mps = 0, .w_mps = 0});
  EXPECT_DOUBLE_EQ(statistics.scalar_mean_speed_horizontal_mps(), 0);
  EXPECT_TRUE(std::isnan(statistics.unit_vector_mean_direction_deg(0)));
}

// EddyPro's result for the same file: wind_dir 292.276 deg, wind_speed 3.33745 m/s.
TEST(WindStatistics, AgreeWithEddyProOnHohesHolz) {
  ROSEAU_REQUIRE_DATA(path, "data/sonic_dehoh_rflux/DE-HoH_EC_201907301200_v01.csv");
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  WindStatistics statistics;
  while (std::getline(file, line)) {
    std::ranges::replace(line, ',', ' ');
    std::istringstream fields(line);
    WindSample sample;
    fields >> sample.u_mps >> sample.v_mps >> sample.w_mps;
    statistics.add(sample);
  }
  EXPECT_EQ(statistics.samples(), 36'000U);
  EXPECT_NEAR(statistics.unit_vector_mean_direction_deg(235), 292.276, 0.0005);
  EXPECT_NEAR(statistics.vector_mean_speed_mps(), 3.33745, 0.00005);
  EXPECT_NEAR(statistics.scalar_mean_speed_3d_mps(), 3.850, 0.0005);
  EXPECT_NEAR(statistics.scalar_mean_speed_horizontal_mps(), 3.678, 0.0005);
}

}  // namespace
}  // namespace roseau
