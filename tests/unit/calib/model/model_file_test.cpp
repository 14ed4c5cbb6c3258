#include "calib/model/model_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

extern "C" {
#include <mrcal/mrcal.h>
}

#include <cmath>
#include <memory>
#include <numbers>

#include "calib/model/python_literal.h"
#include "golden_cameras.h"
#include "tests/support/temporary_folder.h"

namespace roseau::calib {
namespace {

using roseau::testing::TemporaryFolder;
using ::testing::HasSubstr;

void expect_same(const CameraModel& one, const CameraModel& other) {
  EXPECT_EQ(one.lens, other.lens);
  EXPECT_EQ(one.width, other.width);
  EXPECT_EQ(one.height, other.height);
  EXPECT_EQ(one.intrinsics, other.intrinsics);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(one.rotation_camera_from_world.at(i), other.rotation_camera_from_world.at(i), 3e-15) << i;
  }
  EXPECT_NEAR(one.position_in_world_m.x, other.position_in_world_m.x, 1e-14);
  EXPECT_NEAR(one.position_in_world_m.y, other.position_in_world_m.y, 1e-14);
  EXPECT_NEAR(one.position_in_world_m.z, other.position_in_world_m.z, 1e-14);
}

TEST(ModelFile, ReadsWhatMrcalsPythonWrites) {
  const Result<CameraModel> read = parse_camera_model(golden::kFileOfPython, "golden.cameramodel");
  ASSERT_TRUE(read) << read.error().message;
  expect_same(*read, golden::model(golden::cameras()[3]));
}

TEST(ModelFile, MrcalReadsWhatWeWrite) {
  const TemporaryFolder folder;
  for (const golden::Camera& golden : golden::cameras()) {
    CameraModel camera = golden::model(golden);
    camera.intrinsics[0] += 1e-10;  // digits that mrcal's own writer would lose
    const auto path = folder.path() / "ours.cameramodel";
    ASSERT_TRUE(write_camera_model(path, camera));
    const std::unique_ptr<mrcal_cameramodel_t, void (*)(mrcal_cameramodel_t*)> theirs(
        mrcal_read_cameramodel_file(path.c_str()), [](mrcal_cameramodel_t* model) { mrcal_free_cameramodel(&model); });
    ASSERT_TRUE(theirs);
    EXPECT_EQ(mrcal_lensmodel_num_params(&theirs->lensmodel), static_cast<int>(intrinsics_count(golden.lens)));
    EXPECT_EQ(theirs->imagersize[0], 1920U);
    EXPECT_EQ(theirs->imagersize[1], 1080U);
    for (std::size_t i = 0; i < intrinsics_count(golden.lens); ++i) {
      EXPECT_EQ(theirs->intrinsics[i], camera.intrinsics.at(i)) << i;
    }
    const std::array<double, 6> rt{1.7, -0.35, 0.22, 0.4, -1.1, 2.3};
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(theirs->rt_cam_ref[i], rt.at(i), 1e-14) << i;
  }
}

TEST(ModelFile, ComesBackAsItWas) {
  const TemporaryFolder folder;
  for (const golden::Camera& golden : golden::cameras()) {
    CameraModel camera = golden::model(golden);
    camera.intrinsics[2] = 959.1 + 1.0 / 3;
    ASSERT_TRUE(write_camera_model(folder.path() / "c.cameramodel", camera));
    const Result<CameraModel> read = read_camera_model(folder.path() / "c.cameramodel");
    ASSERT_TRUE(read) << read.error().message;
    expect_same(*read, camera);
  }
}

// Rotation vectors are delicate near half a turn, and at none.
TEST(ModelFile, KeepsHalfTurnsAndNoTurn) {
  CameraModel camera = golden::model(golden::cameras()[0]);
  camera.rotation_camera_from_world = {1, 0, 0, 0, -1, 0, 0, 0, -1};
  expect_same(*parse_camera_model(format_camera_model(camera), "half"), camera);
  const double c = std::cos(std::numbers::pi - 1e-7);
  const double s = std::sin(std::numbers::pi - 1e-7);
  camera.rotation_camera_from_world = {c, 0, s, 0, 1, 0, -s, 0, c};
  expect_same(*parse_camera_model(format_camera_model(camera), "almost"), camera);
  camera.rotation_camera_from_world = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  expect_same(*parse_camera_model(format_camera_model(camera), "none"), camera);
}

TEST(ModelFile, SkipsWhatItDoesNotNeed) {
  const Result<CameraModel> read = parse_camera_model(
      "# from a newer version\n{ 'lensmodel': 'LENSMODEL_PINHOLE', 'valid_intrinsics_region': [[1, 2], (3, 4.5e1)],\n"
      "  'extrinsics': (0, 0, 0, +1, -2.0, 3e0), 'intrinsics': [600, 610, 319.5, 239.5], 'imagersize': [640, 480],\n"
      "  'optimization_inputs': b'eJz{}[]\\'#,', 'icam_intrinsics': 0, 'nothing': None, 'inner': {'a': {1: True}} }",
      "newer");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->fy_px(), 610);
  EXPECT_EQ(read->position_in_world_m.x, -1);
  EXPECT_EQ(read->position_in_world_m.y, 2);
}

std::string error_of(const std::string& text) {
  const Result<CameraModel> read = parse_camera_model(text, "camera.cameramodel");
  return read ? "" : read.error().message;
}

TEST(ModelFile, SaysWhatIsWrongAndWhere) {
  const std::string good = format_camera_model(golden::model(golden::cameras()[1]));
  ASSERT_EQ(error_of(good), "");
  const auto with = [&good](const std::string& what, const std::string& instead) {
    std::string text = good;
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return text.replace(at, what.size(), instead);
  };
  EXPECT_THAT(error_of(with("OPENCV4", "CAHVOR")), HasSubstr("camera.cameramodel: lens model \"LENSMODEL_CAHVOR\""));
  EXPECT_THAT(error_of(with("OPENCV4", "OPENCV8")), HasSubstr("camera.cameramodel:5: 'intrinsics' has 8 numbers"));
  EXPECT_THAT(error_of(with("'imagersize'", "'size'")), HasSubstr("'imagersize' is missing"));
  EXPECT_THAT(error_of(with("1920", "1920.5")), HasSubstr("whole numbers"));
  EXPECT_THAT(error_of(with("1601.5", "nan")), HasSubstr("not a finite number"));
  EXPECT_THAT(error_of(with("1601.5", "'1601.5'")), HasSubstr("list of numbers"));
  EXPECT_THAT(error_of(with("'lensmodel':", "'lensmodel'")), HasSubstr("line 2: expected ':'"));
  EXPECT_THAT(error_of(good.substr(0, good.find("1598"))), HasSubstr("line 5: the text ends too early"));
  EXPECT_THAT(error_of(""), HasSubstr("expected '{'"));
  EXPECT_THAT(error_of(std::string("{'a': ") + std::string(100000, '[')), HasSubstr("nested too deeply"));
  EXPECT_THAT(error_of("{'a': 1, 'a': 2}"), HasSubstr("twice"));
  EXPECT_EQ(read_camera_model("/nowhere/c.cameramodel").error().code, ErrorCode::not_found);
}

TEST(ModelFile, RefusesToWriteAnUnusableModel) {
  const TemporaryFolder folder;
  EXPECT_FALSE(write_camera_model(folder.path() / "c.cameramodel", CameraModel{}));
  EXPECT_FALSE(write_camera_model(folder.path() / "no" / "c.cameramodel", golden::model(golden::cameras()[0])));
}

}  // namespace
}  // namespace roseau::calib
