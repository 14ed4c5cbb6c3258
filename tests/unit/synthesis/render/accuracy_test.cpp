// Where things are drawn, against where the camera model says they are.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "core/random.h"
#include "render_support.h"
#include "synthesis/render/vector_math.h"

namespace roseau::render {
namespace {

using namespace render::testing;  // NOLINT(google-build-using-namespace)

constexpr double kGround = 64;  // counts: plain_scene's background, 0.25 * 255 rounded

SceneDescription balls_scene() {
  SceneDescription description = plain_scene();
  for (int i = 0; i < 6; ++i) {
    description.balls.push_back({.node = 2,
                                 .offset_m = {-0.9 + 0.36 * i + (i > 2 ? 0.1 : 0), 0.1 * i - 0.2, 0.11 * i - 1.1},
                                 .diameter_m = 0.04,  // so small that the centre of its ellipse is the centre of the ball
                                 .colour = {0.9, 0.9, 0.9}});
  }
  return description;
}

TEST(Accuracy, BallsStandWhereTheModelPutsThemThroughEveryLens) {
  const auto scene = build(balls_scene());
  std::vector<calib::CameraModel> cameras{calib::look_at(640, 480, 520, {0.3, -3, 1.2}, {0, 0, 1.1}), distorting_camera()};
  cameras.push_back(distorting_camera());
  cameras.back().lens = calib::Lens::opencv4;
  for (const calib::CameraModel& model : cameras) {
    for (const double blur_px : {0.0, 0.8}) {
      CameraOptions options = clean();
      options.lens_blur_px = blur_px;
      FrameRenderer camera = renderer(scene, model, options);
      const calib::Projection projection(model);
      for (int step = 0; step < 5; ++step) {
        const Vec3 shift{0.0037 * step, 0.001, 0.0023 * step};
        const MomentAt at = [&shift](double, SceneMoment& moment) {
          moment.displacement_m[2] = shift;
          moment.rotation_rad[2] = {0, 0.1, 0.05};
        };
        const Pixels pixels = render(camera, at);
        SceneMoment moment = scene->rest();
        at(0, moment);
        for (std::size_t ball = 0; ball < 6; ++ball) {
          if (ball == 2 || ball == 3) continue;  // before the pole
          const Vec2 truth = projection.project(scene->ball_in_world(moment, ball));
          const Vec2 drawn = centroid(pixels, kGround, truth, 14);
          EXPECT_NEAR(drawn.x, truth.x, 0.02) << ball << " step " << step;
          EXPECT_NEAR(drawn.y, truth.y, 0.02) << ball << " step " << step;
        }
      }
    }
  }
}

TEST(Accuracy, BallsHaveTheirSize) {
  const auto scene = build(balls_scene());
  const calib::CameraModel model = calib::look_at(640, 480, 520, {0.3, -3, 1.2}, {0, 0, 1.1});
  FrameRenderer camera = renderer(scene, model, clean());
  const Pixels pixels = render(camera);
  const Vec3 centre = scene->ball_in_world(scene->rest(), 0);
  const Vec2 at = calib::Projection(model).project(centre);
  double area_px = 0;
  const double light = std::round(0.9 * 255) - kGround;
  for (int y = -14; y <= 14; ++y) {
    for (int x = -14; x <= 14; ++x) {
      area_px += (pixels.at(static_cast<std::size_t>(std::lround(at.x) + x), static_cast<std::size_t>(std::lround(at.y) + y)) -
                  kGround) /
                 light;
    }
  }
  // A ball off the axis is seen as an ellipse, longer by 1 / cos of its angle.
  const Vec3 in_camera = calib::to_camera(model, centre);
  const double cosine = in_camera.z / length(in_camera);
  const double radius_px = 0.02 * 520 / in_camera.z;
  EXPECT_NEAR(area_px / (std::numbers::pi * radius_px * radius_px / cosine), 1, 0.01);
}

// How much of its ground each pixel of a row hides: two pictures before different grounds tell, whatever is drawn.
std::vector<double> hidden_in_row(SceneDescription description, const calib::CameraModel& model, const MomentAt& at, double y) {
  std::array<Pixels, 2> pictures;
  for (std::size_t i = 0; i < 2; ++i) {
    const double grey = i == 0 ? 0.1 : 0.9;
    description.background.plain = {grey, grey, grey};
    FrameRenderer camera = renderer(build(description), model, clean());
    pictures.at(i) = render(camera, at);
  }
  std::vector<double> hidden;
  const auto row = static_cast<std::size_t>(std::lround(y));
  for (std::size_t x = 0; x < model.width; ++x) {
    hidden.push_back(1 - (pictures[1].at(x, row) - pictures[0].at(x, row)) / (std::round(0.9 * 255) - std::round(0.1 * 255)));
  }
  return hidden;
}

TEST(Accuracy, WoodReachesFromNodeToNodeWithItsThickness) {
  SceneDescription description = plain_scene();
  for (std::size_t i : {1U, 2U}) description.tree.nodes[i].start_radius_m = description.tree.nodes[i].end_radius_m = 0.04;
  const calib::CameraModel model = calib::look_at(640, 480, 700, {0, -4, 1}, {0, 0, 1});
  const calib::Projection projection(model);
  for (const double shift_m : {0.0, 0.0101, 0.0203}) {
    const MomentAt at = [shift_m](double, SceneMoment& moment) {
      for (Vec3& displacement : moment.displacement_m) displacement = {shift_m, 0, 0};
    };
    const Vec2 middle = projection.project({shift_m, 0, 1.4});
    const std::vector<double> hidden = hidden_in_row(description, model, at, middle.y);
    double width = 0;
    double moment = 0;
    for (std::size_t x = 0; x < hidden.size(); ++x) {
      width += hidden[x];
      moment += hidden[x] * static_cast<double>(x);
    }
    EXPECT_NEAR(moment / width, middle.x, 0.02);
    EXPECT_NEAR(width, 0.08 * 700 / 4, 0.03);
    // Above the tip and its round end there is nothing.
    const std::vector<double> above = hidden_in_row(description, model, at, projection.project({shift_m, 0, 2.05}).y);
    EXPECT_NEAR(*std::ranges::max_element(above), 0, 0.01);
  }
}

// A patch of many leaves in one plane before the camera: it then moves in the picture without changing.
SceneDescription leaves_scene() {
  SceneDescription description = plain_scene();
  const RandomStream random(3, 9);
  for (std::uint64_t i = 0; i < 160; ++i) {
    const double angle = random.uniform(4 * i, 0, 2 * std::numbers::pi);
    description.tree.leaves.push_back(
        {.node = 2,
         .base_m = {random.uniform(4 * i + 1, -0.45, 0.45), 0, 2 + random.uniform(4 * i + 2, -0.35, 0.35)},
         .direction = {std::cos(angle), 0, std::sin(angle)},
         .normal = {0, -1, 0},
         .length_m = 0.10,
         .width_m = 0.06});
  }
  return description;
}

cv::Mat smooth(Pixels& pixels) {
  const auto width = static_cast<int>(pixels.width);
  const cv::Mat image(static_cast<int>(pixels.bytes.size()) / width, width, CV_8UC1, pixels.bytes.data());
  cv::Mat smoothed;
  image.convertTo(smoothed, CV_32F);
  // Detail at the limit of the pixels would pull any interpolating measurement towards the middle between two pixels.
  cv::GaussianBlur(smoothed, smoothed, {}, 1.2);
  return smoothed;
}

// Keys' cubic interpolation: OpenCV's own samplers round the position to 1/32 px.
double sample(const cv::Mat& image, double x, double y) {
  const auto weights = [](double s) {
    return std::array<double, 4>{s * (-0.5 + s * (1 - 0.5 * s)), 1 + s * s * (-2.5 + 1.5 * s), s * (0.5 + s * (2 - 1.5 * s)),
                                 s * s * (-0.5 + 0.5 * s)};
  };
  const int x0 = static_cast<int>(std::floor(x));
  const int y0 = static_cast<int>(std::floor(y));
  const auto wx = weights(x - x0);
  const auto wy = weights(y - y0);
  double sum = 0;
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) {
      sum += wy.at(static_cast<std::size_t>(j)) * wx.at(static_cast<std::size_t>(i)) *
             double{image.at<float>(y0 - 1 + j, x0 - 1 + i)};
    }
  }
  return sum;
}

// Lucas and Kanade's least squares, iterated until it stands.
Vec2 shift_between(const cv::Mat& from, const cv::Mat& to, const cv::Rect& region) {
  Vec2 shift;
  for (int iteration = 0; iteration < 12; ++iteration) {
    double xx = 0;
    double xy = 0;
    double yy = 0;
    double xe = 0;
    double ye = 0;
    for (int y = region.y; y < region.y + region.height; ++y) {
      for (int x = region.x; x < region.x + region.width; ++x) {
        const double gx = 0.5 * double{from.at<float>(y, x + 1) - from.at<float>(y, x - 1)};
        const double gy = 0.5 * double{from.at<float>(y + 1, x) - from.at<float>(y - 1, x)};
        const double error = double{from.at<float>(y, x)} - sample(to, x + shift.x, y + shift.y);
        xx += gx * gx;
        xy += gx * gy;
        yy += gy * gy;
        xe += gx * error;
        ye += gy * error;
      }
    }
    const double determinant = xx * yy - xy * xy;
    shift.x += (yy * xe - xy * ye) / determinant;
    shift.y += (xx * ye - xy * xe) / determinant;
  }
  return shift;
}

TEST(Accuracy, LeavesMoveInThePictureAsProjected) {
  const auto scene = build(leaves_scene());
  const calib::CameraModel model = calib::look_at(320, 240, 600, {0, -5, 2}, {0, 0, 2});
  FrameRenderer camera = renderer(scene, model, clean());
  Pixels rest_pixels = render(camera);
  const cv::Mat rest = smooth(rest_pixels);
  const cv::Rect patch(120, 90, 80, 60);
  for (const Vec3& displacement :
       {Vec3{0.002, 0, 0}, Vec3{0.0043, 0, 0.0031}, Vec3{-0.0125, 0, 0.0208}, Vec3{0.021, 0, -0.004}}) {
    Pixels moved_pixels =
        render(camera, [&displacement](double, SceneMoment& moment) { moment.displacement_m[2] = displacement; });
    const Vec2 shift = shift_between(rest, smooth(moved_pixels), patch);
    EXPECT_NEAR(shift.x, 600 * displacement.x / 5, 0.02);
    EXPECT_NEAR(shift.y, -600 * displacement.z / 5, 0.02);
  }
}

TEST(Accuracy, LeavesTurnWithTheirNode) {
  SceneDescription description = plain_scene();
  description.tree.leaves = {
      {.node = 2, .base_m = {0.2, 0, 2}, .direction = {1, 0, 0}, .normal = {0, -1, 0}, .length_m = 0.3, .width_m = 0.2}};
  const auto scene = build(description);
  const calib::CameraModel model = calib::look_at(320, 240, 600, {0, -5, 2}, {0, 0, 2});
  FrameRenderer camera = renderer(scene, model, clean());
  const calib::Projection projection(model);
  const Pixels flat = render(camera);
  // Middle of the hexagon's area along the blade, from its own outline: half widths 0, 1, .76, 0 at 0, .3, .7, 1 of its length.
  const double along = 0.4773;
  const Vec2 rest = centroid(flat, kGround, {159.5 + 24 + 18, 119.5}, 20);
  EXPECT_NEAR(rest.x, projection.project({0.2 + along * 0.3, 0, 2}).x, 0.1);
  // An eighth of a turn about the line of sight (y, north): what lies east goes down.
  const Pixels turned = render(camera, [](double, SceneMoment& moment) {
    moment.rotation_rad[2] = {0, std::numbers::pi / 4, 0};
  });
  const double reach_m = (0.2 + along * 0.3) * std::numbers::sqrt2 / 2;
  const Vec2 there = projection.project({reach_m, 0, 2 - reach_m});
  const Vec2 drawn = centroid(turned, kGround, there, 19);
  // Along the blade; across it, its halves are of different tone.
  EXPECT_NEAR((drawn.x - there.x + drawn.y - there.y) / std::numbers::sqrt2, 0, 0.1);
  EXPECT_NEAR((drawn.x - there.x - drawn.y + there.y) / std::numbers::sqrt2, 0, 1.5);
}

TEST(Accuracy, AnExposureBlursWhatMovesAndNothingElse) {
  SceneDescription description = plain_scene();
  description.balls = {{.node = 2, .offset_m = {0.6, 0, 0}, .diameter_m = 0.04, .colour = {0.9, 0.9, 0.9}},
                       {.node = 1, .offset_m = {-0.6, 0, 0}, .diameter_m = 0.04, .colour = {0.9, 0.9, 0.9}}};
  const auto scene = build(description);
  const calib::CameraModel model = calib::look_at(640, 480, 520, {0, -3, 1.2}, {0, 0, 1.3});
  const calib::Projection projection(model);
  CameraOptions options = clean();
  options.exposure_taps = 8;
  FrameRenderer camera = renderer(scene, model, options);
  // 5 m/s: 20 mm, 3.5 px, within the exposure.
  const MomentAt at = [](double t, SceneMoment& moment) { moment.displacement_m[2] = {5 * t, 0, 0}; };
  const Pixels moving = render(camera, at, 0.01);
  const Pixels still = render(camera, kRest, 0.01);
  SceneMoment middle = scene->rest();
  at(0.01 + kExposure_s / 2, middle);
  const Vec2 truth = projection.project(scene->ball_in_world(middle, 0));
  const Vec2 drawn = centroid(moving, kGround, truth, 14);
  EXPECT_NEAR(drawn.x, truth.x, 0.02);
  EXPECT_NEAR(drawn.y, truth.y, 0.02);
  const auto variance = [](const Pixels& pixels, const Vec2& c) {
    double sum = 0;
    double second = 0;
    for (std::size_t y = static_cast<std::size_t>(c.y) - 14; y < static_cast<std::size_t>(c.y) + 14; ++y) {
      for (std::size_t x = static_cast<std::size_t>(c.x) - 14; x < static_cast<std::size_t>(c.x) + 14; ++x) {
        sum += pixels.at(x, y) - kGround;
        second += (pixels.at(x, y) - kGround) * std::pow(static_cast<double>(x) - c.x, 2);
      }
    }
    return second / sum;
  };
  const double way_px = 5 * kExposure_s * 520 / 3;
  const Vec2 rest = projection.project(scene->ball_in_world(scene->rest(), 0));
  // Eight taps over a way of d have a variance of d^2 / 12 (1 - 1 / 64).
  EXPECT_NEAR(variance(moving, truth) - variance(still, rest), way_px * way_px / 12 * (1 - 1.0 / 64), 0.06);
  const Vec2 other = projection.project(scene->ball_in_world(scene->rest(), 1));
  EXPECT_NEAR(variance(moving, other), variance(still, other), 0.02);
}

// 100 rows a tenth of a millisecond apart, 10 m/s: what is lower in the picture has moved farther.
TEST(Accuracy, RollingShutterShiftsEachBandByItsTime) {
  SceneDescription description = plain_scene();
  description.balls = {{.node = 2, .offset_m = {0.6, 0, 0}, .diameter_m = 0.04, .colour = {0.9, 0.9, 0.9}},
                       {.node = 2, .offset_m = {0.6, 0, -1.5}, .diameter_m = 0.04, .colour = {0.9, 0.9, 0.9}}};
  const auto scene = build(description);
  const calib::CameraModel model = calib::look_at(640, 480, 520, {0, -3, 1.2}, {0, 0, 1.3});
  const calib::Projection projection(model);
  CameraOptions options = clean();
  options.line_delay_s = 3e-5;
  options.band_rows = 2;
  FrameRenderer camera = renderer(scene, model, options);
  const MomentAt at = [](double t, SceneMoment& moment) { moment.displacement_m[2] = {4 * t, 0, 0}; };
  const Pixels pixels = render(camera, at, 0.003);
  for (std::size_t ball = 0; ball < 2; ++ball) {
    const double row = projection.project(scene->ball_in_world(scene->rest(), ball)).y;
    SceneMoment moment = scene->rest();
    at(0.003 + kExposure_s / 2 + options.line_delay_s * row, moment);
    const Vec2 truth = projection.project(scene->ball_in_world(moment, ball));
    const Vec2 drawn = centroid(pixels, kGround, truth, 14);
    EXPECT_NEAR(drawn.x, truth.x, 0.03) << ball;
    EXPECT_NEAR(drawn.y, truth.y, 0.03) << ball;
  }
}

}  // namespace
}  // namespace roseau::render
