// Small scenes and pictures for the renderer's tests.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "calib/model/projection.h"
#include "synthesis/render/frame_renderer.h"

namespace roseau::render::testing {

/// A trunk of two segments, 2 m high.
inline structure::TreeModel pole() {
  structure::TreeModel tree;
  tree.name = "pole";
  tree.nodes = {{.position_m = {0, 0, 0}},
                {.position_m = {0, 0, 1}, .parent = 0, .start_radius_m = 0.04, .end_radius_m = 0.03},
                {.position_m = {0, 0, 2}, .parent = 1, .start_radius_m = 0.03, .end_radius_m = 0.02}};
  return tree;
}

/// That pole before plain grey, without shading: what is measured is where things are.
inline SceneDescription plain_scene() {
  SceneDescription description;
  description.tree = pole();
  description.background.visible = false;
  description.background.plain = {0.25, 0.25, 0.25};
  description.lighting.sun = 0;
  description.lighting.ambient = 1;
  return description;
}

inline std::shared_ptr<const VisibleScene> build(SceneDescription description) {
  Result<std::shared_ptr<const VisibleScene>> scene = VisibleScene::create(std::move(description));
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
  return *scene;
}

inline CameraOptions clean(PixelFormat format = PixelFormat::mono8) {
  CameraOptions options;
  options.format = format;
  options.read_noise_counts = 0;
  options.shot_noise_gain = 0;
  options.lens_blur_px = 0;
  return options;
}

inline FrameRenderer renderer(const std::shared_ptr<const VisibleScene>& scene, const calib::CameraModel& camera,
                              const CameraOptions& options) {
  Result<FrameRenderer> made = FrameRenderer::create(scene, camera, options);
  EXPECT_TRUE(made) << (made ? "" : made.error().message);
  return std::move(*made);
}

inline const MomentAt kRest = [](double, SceneMoment& moment) {
  std::ranges::fill(moment.displacement_m, Vec3{});
  std::ranges::fill(moment.rotation_rad, Vec3{});
};

constexpr double kExposure_s = 0.004;

struct Pixels {
  std::size_t width = 0;
  std::size_t channels = 1;
  std::vector<std::byte> bytes;

  double at(std::size_t x, std::size_t y, std::size_t channel = 0) const {
    return static_cast<double>(bytes[(y * width + x) * channels + channel]);
  }
};

inline Pixels render(FrameRenderer& renderer, const MomentAt& moment_at = kRest, double start_s = 0, std::uint64_t frame = 0) {
  const std::size_t width = renderer.camera().width;
  Pixels pixels{width, renderer.row_bytes() / width, std::vector<std::byte>(renderer.frame_bytes())};
  renderer.render(frame, start_s, kExposure_s, moment_at, pixels.bytes);
  return pixels;
}

/// Where what differs from `ground` lies on average, weighted by how much, within `reach` px of a point.
inline Vec2 centroid(const Pixels& pixels, double ground, const Vec2& around, double reach) {
  double sum = 0;
  Vec2 moment;
  const auto first = [reach](double c) { return static_cast<std::size_t>(std::max(0.0, std::floor(c - reach))); };
  for (std::size_t y = first(around.y); static_cast<double>(y) <= around.y + reach; ++y) {
    for (std::size_t x = first(around.x); static_cast<double>(x) <= around.x + reach; ++x) {
      const double weight = pixels.at(x, y) - ground;
      sum += weight;
      moment.x += weight * static_cast<double>(x);
      moment.y += weight * static_cast<double>(y);
    }
  }
  return {moment.x / sum, moment.y / sum};
}

/// A wide lens with strong distortion that looks at the pole.
inline calib::CameraModel distorting_camera() {
  calib::CameraModel camera = calib::look_at(640, 480, 520, {0.3, -3, 1.2}, {0, 0, 1.1});
  camera.lens = calib::Lens::opencv8;
  camera.intrinsics = {520, 523, 322.4, 236.7, -0.18, 0.07, 2e-3, -1.5e-3, -0.01, 0.02, 0.01, 0.003};
  return camera;
}

}  // namespace roseau::render::testing
