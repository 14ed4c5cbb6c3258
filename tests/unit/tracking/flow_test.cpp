#include "tracking/flow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/unit/tracking/scene.h"
#include "tracking/feature.h"

namespace roseau::tracking {
namespace {

using Eigen::Vector2d;
using testing::Picture;
using testing::Texture;

const TrackerOptions kDefaults;
const Vector2d kNoShift = Vector2d::Zero();

cv::Mat mat_of(const Picture& picture) {
  cv::Mat mat(picture.height(), picture.width(), CV_8U);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) mat.at<std::uint8_t>(y, x) = picture.pixel(x, y);
  }
  return mat;
}

Picture moved_texture(const Vector2d& shift, std::uint64_t seed = 31) {
  Picture picture(240, 180);
  picture.draw(Texture(seed, 30, 40), {.shift = shift});
  return picture;
}

std::vector<FlowPoint> corners_of(const std::vector<Feature>& features) {
  std::vector<FlowPoint> points;
  for (const Feature& feature : features) {
    const cv::Point2f at(static_cast<float>(feature.position.x()), static_cast<float>(feature.position.y()));
    points.push_back({at, at, {}, false});
  }
  return points;
}

std::vector<FlowPoint> corners(const Flow& flow) {
  return corners_of(find_features(flow, {.area = {0, 0, 240, 180}, .count = 100, .taken = {}, .keep_out = {}}));
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

TEST(Flow, FollowsMotionOfManyPixels) {
  Flow flow(kDefaults);
  flow.advance(mat_of(moved_texture(kNoShift)));
  auto points = corners(flow);
  ASSERT_GT(points.size(), 40U);
  flow.advance(mat_of(moved_texture({11.3, -7.6})));
  flow.follow(points);
  int inside = 0;
  int right = 0;
  for (const FlowPoint& point : points) {
    if (point.from.x > 200 || point.from.y < 30) continue;  // its window leaves the picture
    ++inside;
    const cv::Point2f error = point.to - point.from - cv::Point2f(11.3F, -7.6F);
    if (point.followed && std::hypot(error.x, error.y) < 0.1F) ++right;
  }
  EXPECT_GT(inside, 30);
  EXPECT_GE(right, inside * 9 / 10);
}

TEST(Flow, PointsThatDoNotComeBackAreNotFollowed) {
  Flow flow(kDefaults);
  flow.advance(mat_of(moved_texture(kNoShift)));
  auto points = corners(flow);
  flow.advance(mat_of(moved_texture(kNoShift, 99)));  // another picture altogether
  flow.follow(points);
  const auto followed = std::ranges::count_if(points, [](const FlowPoint& point) { return point.followed; });
  EXPECT_LT(followed, static_cast<std::ptrdiff_t>(points.size() * 3 / 10));
}

TEST(Flow, WithoutAPreviousPictureNothingIsFollowed) {
  Flow flow(kDefaults);
  flow.advance(mat_of(moved_texture(kNoShift)));
  std::vector<FlowPoint> points(1, FlowPoint{{50, 50}, {50, 50}, {}, true});
  flow.follow(points);
  EXPECT_FALSE(points[0].followed);
}

// What the reference patches are there for: flow alone, summed up, walks away, while a point found again by its patch is
// never further off than one match.
TEST(Flow, SummedUpItDriftsWhereReferencePatchesDoNot) {
  std::mt19937_64 random(32);
  const auto loop = [](int i) {
    const double phase = 2 * std::numbers::pi * i / 40;
    return Vector2d(3 * std::sin(phase), 2 * std::sin(2 * phase));
  };
  std::vector<Picture> clean;
  for (int i = 0; i < 40; ++i) clean.push_back(moved_texture(loop(i)));
  const auto noisy = [&](int i) {
    Picture picture = clean[static_cast<std::size_t>(i % 40)];
    picture.add_noise(2, random);
    return mat_of(picture);
  };
  Flow flow(kDefaults);
  flow.advance(noisy(0));
  const auto features = find_features(flow, {.area = {30, 30, 180, 120}, .count = 40, .taken = {}, .keep_out = {}});
  auto points = corners_of(features);
  constexpr int kFrames = 720;
  for (int i = 1; i <= kFrames; ++i) {
    flow.advance(noisy(i));
    flow.follow(points);
    for (FlowPoint& point : points) point.from = point.guess = point.to;
  }
  const Vector2d moved = loop(kFrames) - loop(0);
  std::vector<double> drifts;
  std::vector<double> misses;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector2d truth = features[i].position + moved;
    drifts.push_back((Vector2d(points[i].to.x, points[i].to.y) - truth).norm());
    const PatchMatch match = features[i].patch.align(flow.current(), truth, Eigen::Matrix2d::Identity(), 2);
    misses.push_back((match.position - truth).norm());
  }
  EXPECT_LT(median(misses), 0.03);
  EXPECT_GT(median(drifts), 2 * median(misses)) << "after 24 s; the square root of time makes it ever worse";
}

TEST(Features, KeepTheirDistanceAndStayOutOfWhatIsTaken) {
  Flow flow(kDefaults);
  flow.advance(mat_of(moved_texture(kNoShift)));
  const std::vector<Vector2d> taken = {{60, 60}};
  const std::vector<ImageRect> keep_out = {{120, 0, 60, 180}};
  const auto found = find_features(flow, {.area = {20, 20, 200, 140}, .count = 40, .taken = taken, .keep_out = keep_out});
  ASSERT_GT(found.size(), 15U);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Vector2d& at = found[i].position;
    EXPECT_GE((at - taken[0]).norm(), 7.5);
    EXPECT_FALSE(at.x() > 120 && at.x() < 180) << at.x();
    EXPECT_GE(at.x(), 20);
    EXPECT_LE(at.x(), 220);
    for (std::size_t k = 0; k < i; ++k) EXPECT_GE((at - found[k].position).norm(), 7.5);
  }
}

TEST(Features, NoneOutsideThePicture) {
  Flow flow(kDefaults);
  flow.advance(mat_of(moved_texture(kNoShift)));
  EXPECT_TRUE(find_features(flow, {.area = {500, 500, 50, 50}, .count = 10, .taken = {}, .keep_out = {}}).empty());
  EXPECT_TRUE(find_features(flow, {.area = {20, 20, 50, 50}, .count = 0, .taken = {}, .keep_out = {}}).empty());
}

}  // namespace
}  // namespace roseau::tracking
