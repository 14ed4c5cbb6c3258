#include "tracking/patch.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/tracking/scene.h"

namespace roseau::tracking {
namespace {

using testing::Picture;
using testing::Pose;
using testing::Texture;

cv::Mat mat_of(const Picture& picture) {
  cv::Mat mat(picture.height(), picture.width(), CV_8U);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) mat.at<std::uint8_t>(y, x) = picture.pixel(x, y);
  }
  return mat;
}

Picture texture_at(const Pose& pose, std::uint64_t seed = 2) {
  Picture picture(160, 120);
  picture.draw(Texture(seed), pose);
  return picture;
}

struct Errors {
  double rms_px = 0;
  double mean_x_px = 0;
  int found = 0;
  double least_correlation = 1;
};

/// Aligns patches cut all over `from` in `to`, starting `start_off` away from the truth.
Errors align_all(const Picture& from, const Picture& to, const Pose& truth, const Eigen::Matrix2d& warp,
                 const Eigen::Vector2d& start_off) {
  const cv::Mat reference = mat_of(from);
  const cv::Mat now = mat_of(to);
  Errors errors;
  for (int y = 30; y <= 90; y += 12) {
    for (int x = 30; x <= 130; x += 12) {
      const auto patch = Patch::cut(reference, x, y);
      if (!patch) continue;
      const Eigen::Vector2d half(0.5, 0.5);
      const Eigen::Vector2d material = Eigen::Vector2d(x, y) + half;
      const Eigen::Vector2d expected = truth.centre + truth.turn * (material - truth.centre) + truth.shift - half;
      const PatchMatch match = patch->align(now, expected + start_off, warp, 3);
      if (!match.found) continue;
      ++errors.found;
      errors.rms_px += (match.position - expected).squaredNorm() / 2;
      errors.mean_x_px += match.position.x() - expected.x();
      errors.least_correlation = std::min(errors.least_correlation, match.correlation);
    }
  }
  errors.rms_px = std::sqrt(errors.rms_px / errors.found);
  errors.mean_x_px /= errors.found;
  return errors;
}

const Eigen::Matrix2d kNoWarp = Eigen::Matrix2d::Identity();

TEST(Patch, FindsSubPixelShiftsWithoutDrawingTowardsWholePixels) {
  const Picture from = texture_at({});
  for (const double shift : {0.1, 0.25, 0.5, 0.75, 1.4}) {
    const Pose pose{.shift = {shift, -shift}};
    const Errors errors = align_all(from, texture_at(pose), pose, kNoWarp, {0.7, 0.5});
    EXPECT_GE(errors.found, 50) << shift;
    EXPECT_LT(errors.rms_px, 0.005) << shift;
    EXPECT_LT(std::abs(errors.mean_x_px), 0.003) << shift;
    EXPECT_GT(errors.least_correlation, 0.99) << shift;
  }
}

TEST(Patch, NoiseErrorIsNearItsFloor) {
  std::mt19937_64 random(3);
  const double noise = 4;
  Picture from = texture_at({});
  const Pose pose{.shift = {0.3, 0.8}};
  Picture to = texture_at(pose);
  to.add_noise(noise, random);  // the reference itself is clean here, so that its formula is simple
  const Errors errors = align_all(from, to, pose, kNoWarp, {0.4, -0.4});
  // Floor: sd = noise / sqrt(sum of squared gradients along one direction).
  const cv::Mat reference = mat_of(from);
  double gradient2 = 0;
  for (int y = 30; y < 90; ++y) {
    for (int x = 30; x < 130; ++x) {
      const double gx = 0.5 * (reference.at<std::uint8_t>(y, x + 1) - reference.at<std::uint8_t>(y, x - 1));
      const double gy = 0.5 * (reference.at<std::uint8_t>(y + 1, x) - reference.at<std::uint8_t>(y - 1, x));
      gradient2 += (gx * gx + gy * gy) / 2;
    }
  }
  const double floor_px = noise / std::sqrt(gradient2 / (60 * 100) * Patch::kSide * Patch::kSide);
  EXPECT_LT(errors.rms_px, 1.6 * floor_px);
  EXPECT_GT(errors.rms_px, 0.5 * floor_px);
}

TEST(Patch, BrightnessAndContrastDoNotBias) {
  const Picture from = texture_at({});
  const Pose pose{.shift = {0.4, 0.2}};
  Picture to = texture_at(pose);
  to.scale_light(0.6, 40);
  const Errors errors = align_all(from, to, pose, kNoWarp, {0.5, 0.5});
  EXPECT_GE(errors.found, 50);
  EXPECT_LT(errors.rms_px, 0.008);
  EXPECT_GT(errors.least_correlation, 0.98);
}

TEST(Patch, TurnedTextureIsFoundWithTheRightWarpOnly) {
  const Picture from = texture_at({});
  const Pose pose{.shift = {0.4, 0.2}, .turn = testing::rotation(0.3), .centre = {80, 60}};
  const Picture to = texture_at(pose);
  const Errors warped = align_all(from, to, pose, pose.turn, {0.3, 0.3});
  EXPECT_GE(warped.found, 45);
  EXPECT_LT(warped.rms_px, 0.02);
  EXPECT_GT(warped.least_correlation, 0.97);
  const Errors straight = align_all(from, to, pose, kNoWarp, {0.3, 0.3});
  EXPECT_LT(straight.least_correlation, 0.9);
}

TEST(Patch, OtherTextureDoesNotCorrelate) {
  const Picture from = texture_at({}, 2);
  const cv::Mat reference = mat_of(from);
  const cv::Mat other = mat_of(texture_at({}, 77));
  int accepted = 0;
  int tried = 0;
  for (int y = 20; y < 100; y += 10) {
    for (int x = 20; x < 140; x += 10) {
      const auto patch = Patch::cut(reference, x, y);
      if (!patch) continue;
      ++tried;
      const PatchMatch match = patch->align(other, {x, y}, kNoWarp, 4);
      if (match.found && match.correlation >= 0.75) ++accepted;
    }
  }
  EXPECT_GT(tried, 50);
  EXPECT_LE(accepted, tried / 20);
}

TEST(Patch, RefusesWhatCannotBeFoundAgain) {
  const Picture textured = texture_at({});
  const cv::Mat gray = mat_of(textured);
  EXPECT_FALSE(Patch::cut(gray, 7, 60)) << "leaves the picture";
  EXPECT_TRUE(Patch::cut(gray, 8, 60));
  EXPECT_FALSE(Patch::cut(gray, 160 - 8, 60));
  EXPECT_FALSE(Patch::cut(cv::Mat(120, 160, CV_8U, cv::Scalar(90)), 80, 60)) << "no texture";
  cv::Mat stripes(120, 160, CV_8U);
  for (int x = 0; x < 160; ++x) stripes.col(x).setTo(cv::Scalar(128 + 60 * std::sin(x * 0.5)));
  EXPECT_FALSE(Patch::cut(stripes, 80, 60)) << "can slide along the stripes";
}

TEST(Patch, StopsAtThePicturesEdge) {
  const cv::Mat gray = mat_of(texture_at({}));
  const auto patch = Patch::cut(gray, 80, 60);
  ASSERT_TRUE(patch);
  for (const Eigen::Vector2d& start :
       {Eigen::Vector2d(-5, 60), Eigen::Vector2d(159, 60), Eigen::Vector2d(80, 1e9), Eigen::Vector2d(std::nan(""), 60)}) {
    EXPECT_FALSE(patch->align(gray, start, kNoWarp, 4).found);
    EXPECT_FALSE(patch->align(gray, start, testing::rotation(0.5), 4).found);
  }
}

TEST(Patch, ComesBackFromItsPixels) {
  const cv::Mat gray = mat_of(texture_at({}));
  const auto patch = Patch::cut(gray, 80, 60);
  ASSERT_TRUE(patch);
  const auto again = Patch::from_pixels(patch->pixels());
  ASSERT_TRUE(again);
  const cv::Mat moved = mat_of(texture_at({.shift = {0.3, 0.4}}));
  const PatchMatch a = patch->align(moved, {80, 60}, kNoWarp, 3);
  const PatchMatch b = again->align(moved, {80, 60}, kNoWarp, 3);
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.correlation, b.correlation);
  EXPECT_FALSE(Patch::from_pixels(Patch::Pixels{}));
}

}  // namespace
}  // namespace roseau::tracking
