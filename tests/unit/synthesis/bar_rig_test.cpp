#include "synthesis/rig/bar_rig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "synthesis/instruments/rotation.h"
#include "synthesis/scene.h"

namespace roseau::synthesis {
namespace {

TEST(BarRig, AStiffOneKeepsItsSizesWhereverItIs) {
  BarRigScene scene;
  scene.sag_m = 0;
  scene.survey_error_m = 0;
  const BarRigMotion rig(scene, 3);
  const auto surveyed = BarRigMotion::surveyed_in_rig_m();
  for (const double time_s : {0.0, 7.3, 100.0}) {
    const auto targets = rig.targets_in_world_m(time_s);
    for (std::size_t a = 0; a < targets.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        EXPECT_NEAR(length(targets.at(a) - targets.at(b)), length(surveyed.at(a) - surveyed.at(b)), 1e-12);
      }
    }
  }
}

TEST(BarRig, SagsDownwardsByWhatIsSaidWhereItLiesLevel) {
  BarRigScene scene;
  scene.sag_m = 0.03;
  scene.survey_error_m = 0;
  const BarRigMotion rig(scene, 3);
  scene.sag_m = 0;
  const BarRigMotion stiff(scene, 3);
  for (double time_s = 0; time_s < 60; time_s += 1) {
    const Vec3 end{BarRigMotion::kLongBarEnd_m, 0, 0};
    const Vec3 middle{(BarRigMotion::kLongBarBegin_m + BarRigMotion::kLongBarEnd_m) / 2, 0, 0};
    const Vec3 droop = rig.point_in_world_m(end, time_s) - stiff.point_in_world_m(end, time_s);
    const Vec3 bar = rotated(rig.pose(time_s).world_from_rig, {1, 0, 0});
    EXPECT_NEAR(droop.z, -0.03 * std::hypot(bar.x, bar.y), 1e-12);
    EXPECT_EQ(std::hypot(droop.x, droop.y), 0);
    EXPECT_NEAR(length(rig.point_in_world_m(middle, time_s) - stiff.point_in_world_m(middle, time_s)), 0, 1e-12);
  }
}

TEST(BarRig, CoversItsVolumeAndLeavesItNeverFar) {
  const BarRigScene scene;
  const BarRigMotion rig(scene, 5);
  Vec3 low{99, 99, 99};
  Vec3 high{-99, -99, -99};
  double fastest_mps = 0;
  Vec3 before = rig.point_in_world_m({1.5, 0, 0}, 0);
  for (int i = 1; i <= 6000; ++i) {
    const double time_s = 0.05 * i;
    const Vec3 middle = rig.point_in_world_m({1.5, 0, 0}, time_s);
    fastest_mps = std::max(fastest_mps, length(middle - before) / 0.05);
    before = middle;
    for (const Vec3& target : rig.targets_in_world_m(time_s)) {
      low = {std::min(low.x, target.x), std::min(low.y, target.y), std::min(low.z, target.z)};
      high = {std::max(high.x, target.x), std::max(high.y, target.y), std::max(high.z, target.z)};
    }
  }
  EXPECT_LT(fastest_mps, 1.5 * scene.speed_mps);
  EXPECT_GT(fastest_mps, 0.5 * scene.speed_mps);
  EXPECT_GT(low.z, 0.05);  // above the ground
  EXPECT_LT(low.x, scene.volume_low_in_world_m.x);
  EXPECT_GT(high.x, scene.volume_high_in_world_m.x);
  EXPECT_GT(high.z, 0.85 * scene.volume_high_in_world_m.z);
}

TEST(BarRig, TargetsAreOffTheirSurveyedPlacesByTheErrorThatIsSaid) {
  BarRigScene scene;
  scene.survey_error_m = 0.003;
  double square = 0;
  int count = 0;
  const auto surveyed = BarRigMotion::surveyed_in_rig_m();
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const BarRigMotion rig(scene, seed);
    for (std::size_t i = 0; i < surveyed.size(); ++i) {
      const Vec3 error = rig.true_in_rig_m().at(i) - surveyed.at(i);
      square += dot(error, error);
      count += 3;
    }
  }
  EXPECT_NEAR(std::sqrt(square / count), 0.003, 0.0002);
}

}  // namespace
}  // namespace roseau::synthesis
