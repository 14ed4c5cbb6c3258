#include "calib/model/camera_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "calib/model/projection.h"
#include "golden_cameras.h"

namespace roseau::calib {
namespace {

TEST(CameraModel, LooksAtItsTargetUpright) {
  const CameraModel camera = look_at(640, 480, 800, {-0.3, -5, 1.6}, {0.15, 0, 2.05});
  ASSERT_TRUE(check(camera));
  const Projection projection(camera);
  EXPECT_NEAR(projection.project({0.15, 0, 2.05}).x, 319.5, 1e-9);
  EXPECT_NEAR(projection.project({0.15, 0, 2.05}).y, 239.5, 1e-9);
  EXPECT_GT(projection.project({0.5, 0, 2.05}).x, 319.5);  // east is right
  EXPECT_LT(projection.project({0.15, 0, 2.5}).y, 239.5);  // up is up
  EXPECT_NEAR(to_camera(camera, {0.15, 0, 2.05}).z, std::hypot(0.45, 5, 0.45), 1e-12);
}

TEST(CameraModel, PointsGoToTheCameraAsMrcalTakesThemAndBack) {
  const CameraModel camera = golden::model(golden::cameras().front());
  for (std::size_t i = 0; i < golden::kPoints.size(); ++i) {
    const Vec3 there = to_camera(camera, golden::kPoints.at(i));
    EXPECT_NEAR(there.x, golden::kPointsInCamera.at(i).x, 1e-12);
    EXPECT_NEAR(there.y, golden::kPointsInCamera.at(i).y, 1e-12);
    EXPECT_NEAR(there.z, golden::kPointsInCamera.at(i).z, 1e-12);
    const Vec3 back = to_world(camera, there);
    EXPECT_NEAR(back.x, golden::kPoints.at(i).x, 1e-12);
    EXPECT_NEAR(back.y, golden::kPoints.at(i).y, 1e-12);
    EXPECT_NEAR(back.z, golden::kPoints.at(i).z, 1e-12);
  }
}

TEST(CameraModel, TheMessageSaysTheSameAsTheModel) {
  const CameraModel camera = golden::model(golden::cameras()[2]);
  const Result<CameraCalibration> message = to_calibration(camera);
  ASSERT_TRUE(message) << message.error().message;
  EXPECT_EQ(message->width, 1920U);
  EXPECT_EQ(message->fy_px, 1598.25);
  EXPECT_EQ(message->distortion, (std::array{-0.21, 0.07, 1.5e-3, -8e-4, 0.013}));
  const Result<CameraModel> back = from_calibration(*message);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->lens, Lens::opencv5);
  EXPECT_EQ(back->intrinsics, camera.intrinsics);
  EXPECT_EQ(back->rotation_camera_from_world, camera.rotation_camera_from_world);
  EXPECT_EQ(back->position_in_world_m.z, camera.position_in_world_m.z);
}

TEST(CameraModel, TheMessageOfASimplerLensHasZerosAndOfARicherOneIsRefused) {
  const Result<CameraCalibration> four = to_calibration(golden::model(golden::cameras()[1]));
  ASSERT_TRUE(four);
  EXPECT_EQ(four->distortion, (std::array{-0.21, 0.07, 1.5e-3, -8e-4, 0.0}));
  const Result<CameraCalibration> pinhole = to_calibration(golden::model(golden::cameras()[0]));
  ASSERT_TRUE(pinhole);
  EXPECT_EQ(from_calibration(*pinhole)->lens, Lens::pinhole);
  EXPECT_EQ(to_calibration(golden::model(golden::cameras()[3])).error().code, ErrorCode::unsupported);
  CameraModel plain_eight = golden::model(golden::cameras()[3]);
  plain_eight.intrinsics[9] = plain_eight.intrinsics[10] = plain_eight.intrinsics[11] = 0;
  EXPECT_TRUE(to_calibration(plain_eight));
}

TEST(CameraModel, SaysWhatMakesAModelUnusable) {
  const CameraModel good = golden::model(golden::cameras()[1]);
  ASSERT_TRUE(check(good));
  CameraModel bad = good;
  bad.height = 0;
  EXPECT_FALSE(check(bad));
  bad = good;
  bad.intrinsics[0] = -1601;
  EXPECT_FALSE(check(bad));
  bad = good;
  bad.intrinsics[5] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(check(bad));
  bad = good;
  bad.intrinsics[11] = std::numeric_limits<double>::quiet_NaN();  // not one of this lens
  EXPECT_TRUE(check(bad));
  bad = good;
  bad.rotation_camera_from_world[0] = 0.95;
  EXPECT_FALSE(check(bad));
  bad = good;
  for (double& element : bad.rotation_camera_from_world) element = -element;  // a reflection
  EXPECT_FALSE(check(bad));
  EXPECT_FALSE(from_calibration(CameraCalibration{}));
}

TEST(CameraModel, LensesHaveMrcalsNames) {
  EXPECT_EQ(to_string(Lens::opencv8), "LENSMODEL_OPENCV8");
  EXPECT_EQ(*lens_from_string("LENSMODEL_PINHOLE"), Lens::pinhole);
  EXPECT_EQ(lens_from_string("LENSMODEL_CAHVOR").error().code, ErrorCode::unsupported);
}

}  // namespace
}  // namespace roseau::calib
