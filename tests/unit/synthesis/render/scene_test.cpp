#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render_support.h"
#include "synthesis/render/landscape.h"
#include "synthesis/render/vector_math.h"

namespace roseau::render {
namespace {

using namespace render::testing;  // NOLINT(google-build-using-namespace)

structure::Leaf leaf_at(const Vec3& base) {
  return {.node = 2, .base_m = base, .direction = {0, 0, 1}, .normal = {0, -1, 0}, .length_m = 0.1, .width_m = 0.06};
}

TEST(VisibleScene, BallsMoveAndTurnWithTheirNode) {
  SceneDescription description = plain_scene();
  description.balls = {{.node = 1, .offset_m = {0.2, 0, 0}}};
  const auto scene = build(description);
  SceneMoment moment = scene->rest();
  EXPECT_NEAR(scene->ball_in_world(moment, 0).x, 0.2, 1e-12);
  EXPECT_NEAR(scene->ball_in_world(moment, 0).z, 1, 1e-12);
  moment.displacement_m[1] = {0.01, 0.02, 0.03};
  moment.rotation_rad[1] = {0, 0, std::numbers::pi / 2};  // east goes north
  const Vec3 ball = scene->ball_in_world(moment, 0);
  EXPECT_NEAR(ball.x, 0.01, 1e-12);
  EXPECT_NEAR(ball.y, 0.22, 1e-12);
  EXPECT_NEAR(ball.z, 1.03, 1e-12);
}

TEST(VisibleScene, LeavesBetweenACameraAndABallAreLeftOut) {
  SceneDescription description = plain_scene();
  description.balls = {{.node = 2, .offset_m = {0, -0.1, 0}, .diameter_m = 0.1}};
  description.tree.leaves = {leaf_at({0, -1, 1.95}),    // on the line of sight
                             leaf_at({0.4, -1, 1.95}),  // beside it
                             leaf_at({0, 0.5, 1.95}),   // behind the ball
                             leaf_at({0, -1, 2.5})};    // above it
  EXPECT_EQ(build(description)->leaves().size(), 4U);
  description.viewpoints_in_world_m = {{0, -10, 2}};
  EXPECT_EQ(build(description)->leaves().size(), 3U);
  description.viewpoints_in_world_m.push_back({4, -10, 2});  // sees the ball past x = 0.4 at y = -1.1
  description.tree.leaves[1] = leaf_at({0.36, -1, 1.95});
  EXPECT_EQ(build(description)->leaves().size(), 2U);
}

TEST(VisibleScene, LeavesBelowOthersGetLessLight) {
  SceneDescription description = plain_scene();
  description.lighting.to_sun = {0, 0, 1};
  for (int i = 0; i < 40; ++i) {
    structure::Leaf leaf = leaf_at({0.001 * i - 0.09, 0, 3 - 0.02 * i});
    leaf.direction = {1, 0, 0};
    leaf.normal = {0, 0, 1};
    description.tree.leaves.push_back(leaf);
  }
  const auto scene = build(description);
  EXPECT_EQ(scene->leaves().front().sunlight, 1);
  EXPECT_LT(scene->leaves().back().sunlight, 0.2);
  EXPECT_LT(scene->leaves().back().skylight, scene->leaves().front().skylight);
  EXPECT_LT(scene->wood_sunlight()[2], 0.2);
}

TEST(VisibleScene, RefusesWhatMakesNoSense) {
  SceneDescription description = plain_scene();
  description.balls = {{.node = 3}};
  EXPECT_NE(VisibleScene::create(description).error().message.find("node 3"), std::string::npos);
  description = plain_scene();
  description.balls = {{.node = 2, .diameter_m = 0}};
  EXPECT_FALSE(VisibleScene::create(description));
  description = plain_scene();
  description.led_board = LedBoard{.board_id = 16};
  EXPECT_FALSE(VisibleScene::create(description));
  description.led_board = LedBoard{.pitch_m = 0.01, .led_diameter_m = 0.02};
  EXPECT_FALSE(VisibleScene::create(description));
  description.led_board = LedBoard{.tick_duration_s = 0};
  EXPECT_FALSE(VisibleScene::create(description));
  description = plain_scene();
  description.lighting.to_sun = {};
  EXPECT_FALSE(VisibleScene::create(description));
}

TEST(GroundShadow, LiesWhereTheSunThrowsIt) {
  structure::TreeModel tree = pole();
  for (int i = 0; i < 200; ++i) {
    tree.leaves.push_back(leaf_at({0.002 * i - 0.2, 0, 2}));
    tree.leaves.back().normal = {-1, 0, 0};
  }
  const GroundShadow shadow = cast_shadow(tree, unit({-1, 0, 1}));  // low sun in the west
  EXPECT_GT(shadow.at(2, 0), 0.5);
  EXPECT_LT(shadow.at(-2, 0), 0.01);
  EXPECT_LT(shadow.at(2, 1.5), 0.01);
  EXPECT_EQ(shadow.at(1000, 0), 0);
}

TEST(Landscape, IsTheSamePlaceFromTwoPlaces) {
  const Landscape landscape(5, {});
  // A spot of the hedge, seen from both sides.
  const Vec3 spot{2.0, 13, 0.45};
  const Vec3 one{-1.5, -12, 1.7};
  const Vec3 other{1.5, -12, 1.7};
  const auto from_one = landscape.look(one, subtract(spot, one), 1e-3);
  const auto from_other = landscape.look(other, subtract(spot, other), 1e-3);
  EXPECT_NEAR(from_one.solid.green, from_other.solid.green, 1e-6);
  EXPECT_EQ(from_one.sky_share, 0);
  EXPECT_GT(from_one.sway_rad_per_m, 0);
  const auto up = landscape.look(one, {0, 1, 1}, 1e-3);
  EXPECT_EQ(up.sky_share, 1);
  EXPECT_GT(up.clear_sky.blue, up.clear_sky.red);
}

TEST(Landscape, CloudsDriftWithoutJumpingAndComeAround) {
  const Landscape landscape(5, {});
  const Landscape::CloudCell cell = Landscape::cloud_cell({3.21, 5.43});
  float most = 0;
  float least = 1;
  for (int i = 0; i < 10240; ++i) {
    const float drift = static_cast<float>(i) * 0.1F;
    const float here = landscape.cloud_cover(cell, drift);
    const float next = landscape.cloud_cover(cell, std::fmod(drift + 0.1F, float{Landscape::kCloudColumns}));
    ASSERT_LT(std::abs(next - here), 0.05F) << i;
    most = std::max(most, here);
    least = std::min(least, here);
  }
  EXPECT_GT(most, 0.5F);
  EXPECT_LT(least, 0.1F);
}

}  // namespace
}  // namespace roseau::render
