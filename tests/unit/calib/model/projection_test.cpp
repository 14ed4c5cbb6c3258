#include "calib/model/projection.h"

#include <gtest/gtest.h>

#include <cmath>

#include "golden_cameras.h"

namespace roseau::calib {
namespace {

TEST(Projection, AgreesWithMrcalsPythonForEveryLens) {
  for (const golden::Camera& golden : golden::cameras()) {
    SCOPED_TRACE(to_string(golden.lens));
    const Projection projection(golden::model(golden));
    for (std::size_t i = 0; i < golden::kPoints.size(); ++i) {
      const Vec2 image = projection.project(golden::kPoints.at(i));
      EXPECT_NEAR(image.x, golden.image_points.at(i).x, 1e-9);
      EXPECT_NEAR(image.y, golden.image_points.at(i).y, 1e-9);
    }
    const std::optional<Vec3> ray = projection.unproject(golden::kUnprojected);
    ASSERT_TRUE(ray);
    EXPECT_NEAR(ray->x, golden.ray.x, 1e-7);
    EXPECT_NEAR(ray->y, golden.ray.y, 1e-7);
    EXPECT_NEAR(ray->z, golden.ray.z, 1e-7);
  }
}

TEST(Projection, GradientsAgreeWithMrcalsPython) {
  for (const golden::Camera& golden : golden::cameras()) {
    SCOPED_TRACE(to_string(golden.lens));
    const Projection projection(golden::model(golden));
    ProjectionGradient gradient;
    const Vec2 image = projection.project_in_camera(golden::kPointsInCamera[2], &gradient);
    EXPECT_NEAR(image.x, golden.image_points[2].x, 1e-9);
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(gradient.by_point.at(i), golden.by_point.at(i), 1e-9) << i;
    ASSERT_EQ(golden.by_intrinsics.size(), 2 * intrinsics_count(golden.lens));
    for (std::size_t i = 0; i < golden.by_intrinsics.size(); ++i) {
      EXPECT_NEAR(gradient.by_intrinsics.at(i), golden.by_intrinsics.at(i), 1e-9) << i;
    }
  }
}

TEST(Projection, ManyPointsAreProjectedLikeOne) {
  for (const golden::Camera& golden : golden::cameras()) {
    const Projection projection(golden::model(golden));
    std::array<Vec2, 3> images;
    projection.project_in_camera(golden::kPointsInCamera, images);
    for (std::size_t i = 0; i < images.size(); ++i) {
      EXPECT_NEAR(images.at(i).x, golden.image_points.at(i).x, 1e-9);
      EXPECT_NEAR(images.at(i).y, golden.image_points.at(i).y, 1e-9);
    }
  }
}

TEST(Projection, TheRayThroughAnImagePointLeadsBackToThePoint) {
  for (const golden::Camera& golden : golden::cameras()) {
    const Projection projection(golden::model(golden));
    const CameraModel& camera = projection.camera();
    const Vec3 target{3.5, 12.0, 0.4};
    const std::optional<Vec3> ray = projection.ray_in_world(projection.project(target));
    ASSERT_TRUE(ray);
    const Vec3 to_target{target.x - camera.position_in_world_m.x, target.y - camera.position_in_world_m.y,
                         target.z - camera.position_in_world_m.z};
    const double distance = std::hypot(to_target.x, to_target.y, to_target.z);
    EXPECT_NEAR(ray->x, to_target.x / distance, 1e-6);
    EXPECT_NEAR(ray->y, to_target.y / distance, 1e-6);
    EXPECT_NEAR(ray->z, to_target.z / distance, 1e-6);
  }
}

TEST(Projection, DoesNotSeeWhatLiesBehindOrWhereTheLensFormulaFoldsBack) {
  CameraModel camera = look_at(640, 480, 600, {0, -10, 1.5}, {0, 0, 1.5});
  const Projection plain(camera);
  EXPECT_TRUE(plain.sees({0, 0, 2}));
  EXPECT_FALSE(plain.sees({0, 0, -2}));
  EXPECT_FALSE(plain.sees({0, 0, 2}, 2.5));
  EXPECT_TRUE(plain.sees({8, 0, 2}));

  // r (1 - 0.3 r^2) grows up to r = 1.054 only.
  camera.lens = Lens::opencv4;
  camera.intrinsics[4] = -0.3;
  const Projection barrel(camera);
  EXPECT_NEAR(barrel.largest_tangent(), std::sqrt(1 / 0.9), 1.0 / 128);
  EXPECT_TRUE(barrel.sees({1.0, 0, 1}));
  EXPECT_FALSE(barrel.sees({1.1, 0, 1}));
  // The picture's edge ends at r = 1.054 with 600 * 1.054 * 2 / 3 = 422 px from the centre.
  EXPECT_TRUE(barrel.unproject({319.5 + 400, 239.5}));
  EXPECT_FALSE(barrel.unproject({319.5 + 440, 239.5}));
}

}  // namespace
}  // namespace roseau::calib
