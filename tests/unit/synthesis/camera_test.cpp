#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <set>
#include <vector>

#include "synthesis/camera/branch_shape.h"
#include "synthesis/camera/branch_warp.h"
#include "synthesis/camera/frame_renderer.h"
#include "synthesis/camera/objects.h"
#include "synthesis/camera/pinhole.h"
#include "synthesis/camera/sensor_noise.h"
#include "synthesis/scene.h"

namespace roseau::synthesis {
namespace {

Scene without_noise(PixelFormat format = PixelFormat::mono8) {
  Scene scene;
  for (CameraScene& camera : scene.cameras) {
    camera.format = format;
    camera.read_noise_counts = 0;
    camera.shot_noise_gain = 0;
  }
  return scene;
}

cv::Mat picture(FrameRenderer& renderer, const std::vector<double>& deflections_m, std::uint64_t frame = 0) {
  cv::Mat image(static_cast<int>(renderer.calibration().height), static_cast<int>(renderer.row_bytes()), CV_8UC1);
  renderer.render(deflections_m, frame, {reinterpret_cast<std::byte*>(image.data), renderer.frame_bytes()});
  return image;
}

TEST(Pinhole, LooksAtItsTargetUprightAndInvertsItsProjection) {
  const CameraCalibration camera = look_at(640, 480, 800, {-0.3, -5, 1.6}, {0.15, 0, 2.05});
  EXPECT_NEAR(project(camera, {0.15, 0, 2.05}).x, 319.5, 1e-9);
  EXPECT_NEAR(project(camera, {0.15, 0, 2.05}).y, 239.5, 1e-9);
  EXPECT_GT(project(camera, {0.5, 0, 2.05}).x, 319.5);  // east is right
  EXPECT_LT(project(camera, {0.15, 0, 2.5}).y, 239.5);  // up is up
  const Vec3 back = on_plane(camera, project(camera, {0.7, 1.5, 2.3}), 1.5);
  EXPECT_NEAR(back.x, 0.7, 1e-9);
  EXPECT_NEAR(back.z, 2.3, 1e-9);
}

TEST(BranchShape, BendsAsAQuadraticAndMovesItsTopAsAWhole) {
  EXPECT_EQ(bending_gain(-1), 0);
  EXPECT_NEAR(bending_gain(0.4) / bending_gain(0.2), 4, 1e-12);
  EXPECT_EQ(bending_gain(kStiffBegin), 1);
  EXPECT_EQ(bending_gain(1.2), 1);
  const double step = 1e-6;
  for (const double joint : {kBendEnd, kStiffBegin}) {
    EXPECT_NEAR(bending_gain(joint + step), bending_gain(joint - step), 1e-5);
    EXPECT_NEAR(bending_gain(joint + step) - bending_gain(joint), bending_gain(joint) - bending_gain(joint - step), 1e-9);
  }
}

// The branch alone, before black: nothing else in the picture can mislead the measurement.
cv::Mat branch_alone(const Scene& scene, std::size_t camera_index, double deflection_m) {
  const CameraCalibration camera = calibration_of(scene.cameras[camera_index]);
  const BranchScene& branch = scene.branch;
  const Layer texture = draw_branch(branch.root_in_world_m, branch.length_m, 320, 1.6, scene.seed);
  BranchWarp warp(texture, camera, branch.root_in_world_m.z, branch.length_m, 0.5, 1);
  cv::Mat picture = cv::Mat::zeros(static_cast<int>(camera.height), static_cast<int>(camera.width), CV_8UC1);
  for (std::uint32_t y = warp.first_row(); y < warp.end_row(); ++y) {
    warp.draw_row(y, std::array{deflection_m}, {picture.ptr<uchar>(static_cast<int>(y)), camera.width});
  }
  cv::Mat as_float;
  picture.convertTo(as_float, CV_32F);
  // Detail at the limit of the pixels would pull any interpolating measurement towards the middle between two pixels.
  cv::GaussianBlur(as_float, as_float, {}, 1.0);
  return as_float;
}

// Keys' cubic interpolation: OpenCV's own samplers round the position to 1/32 px.
double sample(const cv::Mat& image, double x, double y) {
  const auto weights = [](double s) {
    return std::array{s * (-0.5 + s * (1 - 0.5 * s)), 1 + s * s * (-2.5 + 1.5 * s), s * (0.5 + s * (2 - 1.5 * s)),
                      s * s * (-0.5 + 0.5 * s)};
  };
  const auto wx = weights(x - std::floor(x));
  const auto wy = weights(y - std::floor(y));
  double sum = 0;
  for (int j = 0; j < 4; ++j) {
    const float* row = image.ptr<float>(static_cast<int>(std::floor(y)) - 1 + j) + static_cast<int>(std::floor(x)) - 1;
    for (int i = 0; i < 4; ++i) sum += wy.at(static_cast<std::size_t>(j)) * wx.at(static_cast<std::size_t>(i)) * row[i];
  }
  return sum;
}

// Lucas-Kanade on one square patch: where the patch of `from` around `centre` is in `to`, starting at `guess`.
Vec2 find_patch(const cv::Mat& from, const Vec2& centre, const cv::Mat& to, Vec2 guess, int half) {
  for (int iteration = 0; iteration < 10; ++iteration) {
    double xx = 0, xy = 0, yy = 0, xe = 0, ye = 0;
    for (int j = -half; j <= half; ++j) {
      for (int i = -half; i <= half; ++i) {
        const double x = guess.x + i;
        const double y = guess.y + j;
        const double gx = (sample(to, x + 0.5, y) - sample(to, x - 0.5, y));
        const double gy = (sample(to, x, y + 0.5) - sample(to, x, y - 0.5));
        const double error = sample(from, centre.x + i, centre.y + j) - sample(to, x, y);
        xx += gx * gx, xy += gx * gy, yy += gy * gy, xe += gx * error, ye += gy * error;
      }
    }
    const double determinant = xx * yy - xy * xy;
    guess.x += (yy * xe - xy * ye) / determinant;
    guess.y += (xx * ye - xy * xe) / determinant;
  }
  return guess;
}

TEST(BranchWarp, MovesTheTargetWhereTheTruthSaysToTwoHundredthsOfAPixel) {
  const Scene scene;
  for (const std::size_t camera : {0U, 1U}) {
    const cv::Mat rest = branch_alone(scene, camera, 0);
    const ImageRect region = target_region(scene, scene.cameras[camera], 0);
    const Vec2 centre{region.x + region.width / 2 - 0.5, region.y + region.height / 2 - 0.5};
    for (const double deflection_m : {-0.0213, 0.0032, 0.0625, 0.1473}) {
      const cv::Mat bent = branch_alone(scene, camera, deflection_m);
      const Vec2 truth = target_displacement_px(scene, scene.cameras[camera], deflection_m);
      const Vec2 guess{centre.x + truth.x + 0.4, centre.y + truth.y - 0.3};
      const Vec2 found = find_patch(rest, centre, bent, guess, 35);
      EXPECT_NEAR(found.x - centre.x, truth.x, 0.02) << "camera " << camera << ", deflection " << deflection_m << " m";
      EXPECT_NEAR(found.y - centre.y, truth.y, 0.02) << "camera " << camera << ", deflection " << deflection_m << " m";
    }
  }
}

// Small patches, which sampling into pixels alone moves by a few hundredths, show that every height moves by its own amount.
TEST(BranchWarp, BendsTheStemWithHeight) {
  const Scene scene;
  const CameraCalibration camera = calibration_of(scene.cameras[0]);
  const Vec3 root = scene.branch.root_in_world_m;
  const cv::Mat rest = branch_alone(scene, 0, 0);
  const cv::Mat bent = branch_alone(scene, 0, 0.03);
  for (const auto& [x_m, z_m] : {std::pair{0.06, 1.88}, {0.17, 2.20}, {0.26, 2.47}, {0.33, 2.75}}) {
    const double moved_m = 0.03 * bending_gain((z_m - root.z) / scene.branch.length_m);
    const Vec2 from = project(camera, {x_m, root.y, z_m});
    const Vec2 expected = project(camera, {x_m + moved_m, root.y, z_m});
    const Vec2 found = find_patch(rest, from, bent, expected, 7);
    EXPECT_NEAR(found.x, expected.x, 0.08) << "at height " << z_m << ", moved by " << expected.x - from.x << " px";
  }
}

// What a tracker would report of whole pictures: leaves before sky and cloud, which do not move with them.
TEST(FrameRenderer, TheTargetsMeanMotionIsTheTruth) {
  const Scene scene = without_noise();
  for (const std::size_t camera : {0U, 1U}) {
    FrameRenderer renderer(scene, camera);
    const cv::Mat rest = picture(renderer, {0});
    const ImageRect region = target_region(scene, scene.cameras[camera], 0);
    cv::Mat mask = cv::Mat::zeros(rest.size(), CV_8UC1);
    mask(cv::Rect(static_cast<int>(region.x), static_cast<int>(region.y), static_cast<int>(region.width),
                  static_cast<int>(region.height))) = 255;
    std::vector<cv::Point2f> corners;
    cv::goodFeaturesToTrack(rest, corners, 60, 0.05, 6, mask);
    ASSERT_GE(corners.size(), 30U);
    for (const double deflection_m : {-0.021, 0.0032, 0.0625}) {
      const cv::Mat bent = picture(renderer, {deflection_m});
      std::vector<cv::Point2f> found;
      std::vector<uchar> status;
      std::vector<float> residual;
      cv::calcOpticalFlowPyrLK(rest, bent, corners, found, status, residual, {15, 15}, 3);
      std::vector<float> dx;
      std::vector<float> dy;
      for (std::size_t i = 0; i < corners.size(); ++i) {
        dx.push_back(found[i].x - corners[i].x);
        dy.push_back(found[i].y - corners[i].y);
      }
      const auto median = [](std::vector<float>& values) {
        std::ranges::nth_element(values, values.begin() + std::ssize(values) / 2);
        return static_cast<double>(values[values.size() / 2]);
      };
      const Vec2 truth = target_displacement_px(scene, scene.cameras[camera], deflection_m);
      EXPECT_NEAR(median(dx), truth.x, 0.05) << "camera " << camera << ", deflection " << deflection_m << " m";
      EXPECT_NEAR(median(dy), truth.y, 0.05) << "camera " << camera << ", deflection " << deflection_m << " m";
    }
  }
}

TEST(FrameRenderer, MeanDeflectionIsAboutTenPixels) {
  const Scene scene;
  EXPECT_NEAR(target_displacement_px(scene, scene.cameras[0], scene.branch.mean_deflection_m).x, 10, 0.5);
}

TEST(FrameRenderer, OnlyTheBranchMoves) {
  const Scene scene = without_noise();
  FrameRenderer renderer(scene, 0);
  const cv::Mat one = picture(renderer, {0});
  const cv::Mat other = picture(renderer, {0.2});
  cv::Mat difference;
  cv::absdiff(one, other, difference);
  const ImageRect rest = target_region(scene, scene.cameras[0], 0);
  const auto region =
      cv::Rect(static_cast<int>(rest.x), static_cast<int>(rest.y), static_cast<int>(rest.width), static_cast<int>(rest.height));
  EXPECT_GT(cv::mean(difference(region))[0], 10);
  EXPECT_EQ(cv::countNonZero(difference.colRange(0, 200)), 0);    // the static crown
  EXPECT_EQ(cv::countNonZero(difference.rowRange(360, 480)), 0);  // trunk and meadow
}

TEST(FrameRenderer, AFrameIsAFunctionOfSceneAndNumber) {
  const Scene scene;
  FrameRenderer renderer(scene, 0);
  FrameRenderer again(scene, 0);
  const cv::Mat frame7 = picture(renderer, {0.05}, 7);
  const cv::Mat frame8 = picture(renderer, {0.05}, 8);
  const cv::Mat frame7_later = picture(again, {0.05}, 7);
  EXPECT_EQ(cv::norm(frame7, frame7_later, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(frame7, frame8, cv::NORM_L1), 0);

  Scene other = scene;
  other.seed = 2;
  FrameRenderer elsewhere(other, 0);
  EXPECT_GT(cv::norm(frame7, picture(elsewhere, {0.05}, 7), cv::NORM_L1), 0);
}

TEST(FrameRenderer, ExposureAveragesItsTaps) {
  const Scene scene = without_noise();
  FrameRenderer renderer(scene, 0);
  cv::Mat mean;
  cv::addWeighted(picture(renderer, {0.01}), 0.5, picture(renderer, {0.03}), 0.5, 0, mean);
  EXPECT_LE(cv::norm(mean, picture(renderer, {0.01, 0.03}), cv::NORM_INF), 2);  // rounding
}

TEST(FrameRenderer, FormatsShowTheSamePicture) {
  FrameRenderer grey_renderer(without_noise(PixelFormat::mono8), 1);
  FrameRenderer bgr_renderer(without_noise(PixelFormat::bgr8), 1);
  FrameRenderer rgb_renderer(without_noise(PixelFormat::rgb8), 1);
  const cv::Mat grey = picture(grey_renderer, {0.05});
  cv::Mat from_bgr;
  cv::Mat from_rgb;
  cv::cvtColor(picture(bgr_renderer, {0.05}).reshape(3), from_bgr, cv::COLOR_BGR2GRAY);
  cv::cvtColor(picture(rgb_renderer, {0.05}).reshape(3), from_rgb, cv::COLOR_RGB2GRAY);
  EXPECT_LE(cv::norm(grey, from_bgr, cv::NORM_INF), 2);
  EXPECT_EQ(cv::norm(from_bgr, from_rgb, cv::NORM_INF), 0);
}

TEST(SensorNoise, HasTheStatedSpreadAndNoBias) {
  constexpr std::size_t kRow = 4096;
  const SensorNoise noise({.read_noise_counts = 1.5, .shot_noise_gain = 0.03}, 9, kRow);
  std::vector<std::uint8_t> noisy(kRow);
  for (const int signal : {20, 120, 220}) {
    const std::vector<std::uint8_t> clean(kRow, static_cast<std::uint8_t>(signal));
    double sum = 0;
    double sum2 = 0;
    for (std::uint32_t row = 0; row < 100; ++row) {
      noise.apply(clean, 3, row, noisy);
      for (const std::uint8_t value : noisy) {
        sum += value - signal;
        sum2 += (value - signal) * (value - signal);
      }
    }
    const double n = 100.0 * kRow;
    const double variance = 1.5 * 1.5 + 0.03 * signal + 1.0 / 12;  // and rounding
    EXPECT_NEAR(sum / n, 0, 0.05);
    EXPECT_NEAR(sum2 / n / variance, 1, 0.03);
  }
}

TEST(SensorNoise, NoTwoRowsOfAnyFramesShareTheirNoise) {
  constexpr std::size_t kRow = 256;
  const SensorNoise noise({}, 9, kRow);
  const std::vector<std::uint8_t> clean(kRow, 100);
  std::set<std::vector<std::uint8_t>> seen;
  for (std::uint64_t frame = 0; frame < 8; ++frame) {
    for (std::uint32_t row = 0; row < 8; ++row) {
      std::vector<std::uint8_t> noisy(kRow);
      noise.apply(clean, frame, row, noisy);
      EXPECT_TRUE(seen.insert(noisy).second) << "frame " << frame << ", row " << row;
    }
  }
}

}  // namespace
}  // namespace roseau::synthesis
