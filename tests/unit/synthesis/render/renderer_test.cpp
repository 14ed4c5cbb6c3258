#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "render_support.h"

namespace roseau::render {
namespace {

using namespace render::testing;  // NOLINT(google-build-using-namespace)

SceneDescription full_scene() {
  SceneDescription description;
  description.tree = pole();
  for (int i = 0; i < 60; ++i) {
    description.tree.leaves.push_back({.node = 2,
                                       .base_m = {0.3 * std::sin(1.7 * i), 0.3 * std::cos(2.9 * i), 1.8 + 0.01 * i},
                                       .direction = {std::cos(0.7 * i), 0, std::sin(0.7 * i)},
                                       .normal = {0, -1, 0},
                                       .length_m = 0.12,
                                       .width_m = 0.07});
  }
  description.balls = {{.node = 2, .offset_m = {0.3, -0.4, 0.1}, .colour = {0.9, 0.1, 0.1}}};
  description.led_board = LedBoard{.centre_in_world_m = {0.5, -1, 0.5}};
  description.bar_rig = BarRig{};
  description.sonic = SonicMast{{1, 0.5, 2}};
  return description;
}

const MomentAt kSway = [](double t, SceneMoment& moment) {
  moment.displacement_m[2] = {0.1 * std::sin(6 * t), 0.05 * std::cos(5 * t), 0};
  moment.displacement_m[1] = {0.03 * std::sin(6 * t), 0, 0};
  moment.board_time_s = t;
  moment.light_level = 1 - 0.1 * t;
};

calib::CameraModel small_camera() { return calib::look_at(160, 120, 120, {0, -4, 1.5}, {0, 0, 1.3}); }

TEST(FrameRenderer, FramesAreAFunctionOfTheirArgumentsInAnyOrder) {
  const auto scene = build(full_scene());
  CameraOptions options;
  options.exposure_taps = 2;
  FrameRenderer forwards = renderer(scene, small_camera(), options);
  FrameRenderer backwards = renderer(scene, small_camera(), options);
  std::vector<Pixels> frames;
  for (std::uint64_t i = 0; i < 8; ++i) frames.push_back(render(forwards, kSway, 0.11 * static_cast<double>(i), i));
  for (std::uint64_t i = 8; i-- > 0;) {
    EXPECT_EQ(render(backwards, kSway, 0.11 * static_cast<double>(i), i).bytes, frames[i].bytes) << i;
  }
  EXPECT_NE(frames[1].bytes, frames[2].bytes);
}

TEST(FrameRenderer, FormatsShowTheSamePicture) {
  const auto scene = build(full_scene());
  FrameRenderer bgr = renderer(scene, small_camera(), clean(PixelFormat::bgr8));
  FrameRenderer rgb = renderer(scene, small_camera(), clean(PixelFormat::rgb8));
  FrameRenderer mono = renderer(scene, small_camera(), clean(PixelFormat::mono8));
  const Pixels in_bgr = render(bgr, kSway, 0.3);
  const Pixels in_rgb = render(rgb, kSway, 0.3);
  const Pixels in_mono = render(mono, kSway, 0.3);
  ASSERT_EQ(in_bgr.bytes.size(), 160U * 120 * 3);
  ASSERT_EQ(in_mono.bytes.size(), 160U * 120);
  double deviation = 0;
  for (std::size_t y = 0; y < 120; ++y) {
    for (std::size_t x = 0; x < 160; ++x) {
      for (std::size_t c = 0; c < 3; ++c) ASSERT_EQ(in_bgr.at(x, y, c), in_rgb.at(x, y, 2 - c));
      const double luma = 0.114 * in_bgr.at(x, y, 0) + 0.587 * in_bgr.at(x, y, 1) + 0.299 * in_bgr.at(x, y, 2);
      const bool cut_off = std::max({in_bgr.at(x, y, 0), in_bgr.at(x, y, 1), in_bgr.at(x, y, 2)}) > 253;
      if (!cut_off) deviation = std::max(deviation, std::abs(luma - in_mono.at(x, y)));
    }
  }
  EXPECT_LT(deviation, 2.5);
}

TEST(FrameRenderer, ColoursAreTheirs) {
  SceneDescription description = plain_scene();
  description.balls = {{.node = 2, .offset_m = {0.5, -0.1, -0.6}, .diameter_m = 0.3, .colour = {0.8, 0.4, 0.1}}};
  FrameRenderer camera = renderer(build(description), small_camera(), clean(PixelFormat::bgr8));
  const Vec2 at = calib::Projection(camera.camera()).project({0.5, -0.1, 1.4});
  const Pixels pixels = render(camera);
  const auto x = static_cast<std::size_t>(std::lround(at.x));
  const auto y = static_cast<std::size_t>(std::lround(at.y));
  EXPECT_NEAR(pixels.at(x, y, 0), 0.1 * 255, 1);
  EXPECT_NEAR(pixels.at(x, y, 1), 0.4 * 255, 1);
  EXPECT_NEAR(pixels.at(x, y, 2), 0.8 * 255, 1);
}

TEST(FrameRenderer, TheNearerHidesTheFarther) {
  SceneDescription description = plain_scene();
  // Two balls on one line of sight, listed in both orders; they swap places as the tree moves.
  description.balls = {{.node = 2, .offset_m = {0.5, 0.5, -0.5}, .diameter_m = 0.3, .colour = {0.8, 0.8, 0.8}},
                       {.node = 1, .offset_m = {0.5, 0.0, 0.5}, .diameter_m = 0.3, .colour = {0.1, 0.1, 0.1}}};
  const auto scene = build(description);
  FrameRenderer camera = renderer(scene, calib::look_at(160, 120, 120, {0.5, -4, 1.5}, {0.5, 0, 1.5}), clean());
  EXPECT_NEAR(render(camera).at(80, 60), 0.1 * 255, 1);
  const Pixels swapped = render(camera, [](double, SceneMoment& moment) { moment.displacement_m[1] = {0, 1, 0}; });
  EXPECT_NEAR(swapped.at(80, 60), 0.8 * 255, 1);
  EXPECT_NEAR(render(camera).at(80, 60), 0.1 * 255, 1);  // and back again
}

TEST(FrameRenderer, DoesNotDrawWhatIsBehindTheCameraOrAllAroundIt) {
  SceneDescription description = plain_scene();
  description.balls = {{.node = 2, .offset_m = {0, -8, 0}, .diameter_m = 0.5, .colour = {1, 1, 1}}};
  FrameRenderer camera = renderer(build(description), calib::look_at(160, 120, 120, {0.5, -4, 1.5}, {0.5, 0, 1.5}), clean());
  const Pixels pixels = render(camera);
  EXPECT_TRUE(std::ranges::all_of(pixels.bytes, [](std::byte b) { return static_cast<int>(b) < 150; }));
  // The camera inside a ball: nothing sensible to show, and nothing to break.
  const Pixels inside = render(camera, [](double, SceneMoment& moment) { moment.displacement_m[2] = {0.5, 4, -0.5}; });
  EXPECT_EQ(inside.bytes.size(), pixels.bytes.size());
}

TEST(FrameRenderer, CloudsHedgeAndLightChangeWithTimeAndNothingElseAtRest) {
  SceneDescription description = full_scene();
  description.background.cloud_speed_mps = 0;
  description.background.hedge_sway_m = 0;
  FrameRenderer still = renderer(build(description), small_camera(), clean());
  EXPECT_EQ(render(still, kRest, 0).bytes, render(still, kRest, 3).bytes);

  description.background.cloud_speed_mps = 8;
  FrameRenderer clouds = renderer(build(description), small_camera(), clean());
  const Pixels first = render(clouds, kRest, 0);
  const Pixels later = render(clouds, kRest, 20);
  const auto differ = [&](std::size_t from_row, std::size_t to_row, const Pixels& a, const Pixels& b) {
    return !std::equal(a.bytes.begin() + static_cast<std::ptrdiff_t>(160 * from_row),
                       a.bytes.begin() + static_cast<std::ptrdiff_t>(160 * to_row),
                       b.bytes.begin() + static_cast<std::ptrdiff_t>(160 * from_row));
  };
  EXPECT_TRUE(differ(0, 30, first, later));
  EXPECT_FALSE(differ(90, 120, first, later));

  description.background.cloud_speed_mps = 0;
  description.background.hedge_sway_m = 0.4;
  FrameRenderer hedge = renderer(build(description), small_camera(), clean());
  const Pixels here = render(hedge, kRest, 0);
  const Pixels there = render(hedge, kRest, 0.4);
  EXPECT_TRUE(differ(50, 80, here, there));
  EXPECT_FALSE(differ(0, 20, here, there));
  const Pixels calm = render(
      hedge, [](double, SceneMoment& moment) { moment.background_sway = 0; }, 0.4);
  EXPECT_EQ(calm.bytes, render(still, kRest, 0.4).bytes);
}

TEST(FrameRenderer, AsksForOneMomentPerTapAndBandWithinTheExposure) {
  const auto scene = build(plain_scene());
  CameraOptions options = clean();
  options.exposure_taps = 4;
  FrameRenderer camera = renderer(scene, small_camera(), options);
  std::vector<double> asked;
  render(
      camera, [&asked](double t, SceneMoment&) { asked.push_back(t); }, 2);
  ASSERT_EQ(asked.size(), 4U);
  EXPECT_TRUE(std::ranges::is_sorted(asked));
  EXPECT_NEAR(asked.front(), 2 + kExposure_s / 8, 1e-12);
  EXPECT_NEAR(asked.back(), 2 + kExposure_s * 7 / 8, 1e-12);

  asked.clear();
  options.exposure_taps = 1;
  options.line_delay_s = 1e-5;
  options.band_rows = 50;  // of 120: bands of 50, 50 and 20
  FrameRenderer rolling = renderer(scene, small_camera(), options);
  render(
      rolling, [&asked](double t, SceneMoment&) { asked.push_back(t); }, 2);
  ASSERT_EQ(asked.size(), 3U);
  EXPECT_NEAR(asked[0], 2 + kExposure_s / 2 + 24.5e-5, 1e-12);
  EXPECT_NEAR(asked[2], 2 + kExposure_s / 2 + 109.5e-5, 1e-12);
}

TEST(FrameRenderer, RefusesWhatItCannotDraw) {
  const auto scene = build(plain_scene());
  const auto error = [&scene](const calib::CameraModel& camera, const CameraOptions& options) {
    const Result<FrameRenderer> made = FrameRenderer::create(scene, camera, options);
    return made ? std::string() : made.error().message;
  };
  EXPECT_EQ(error(small_camera(), {}), "");
  EXPECT_NE(error(small_camera(), {.format = PixelFormat::mono16}).find("mono16"), std::string::npos);
  EXPECT_NE(error(small_camera(), {.exposure_taps = 0}).find("exposure_taps"), std::string::npos);
  EXPECT_NE(error(small_camera(), {.lens_blur_px = -1}).find("lens_blur_px"), std::string::npos);
  EXPECT_NE(error(small_camera(), {.gain = std::nan("")}).find("gain"), std::string::npos);
  EXPECT_NE(error(small_camera(), {.line_delay_s = 1}).find("line_delay_s"), std::string::npos);
  EXPECT_NE(error(small_camera(), {.band_rows = 0}).find("band_rows"), std::string::npos);
  calib::CameraModel large = small_camera();
  large.width = 100000;
  EXPECT_NE(error(large, {}).find("100000"), std::string::npos);
  EXPECT_NE(error(calib::CameraModel{}, {}), "");
}

}  // namespace
}  // namespace roseau::render
