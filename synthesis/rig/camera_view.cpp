#include "synthesis/rig/camera_view.h"

#include <utility>

#include "core/check.h"

namespace roseau::synthesis {

namespace {

constexpr std::uint64_t kMostCameras = 16;  // keeps the noise of one seed's cameras apart from the next seed's

render::FrameRenderer make_renderer(const World& world, std::size_t index) {
  const CameraScene& camera = world.scene().cameras.at(index);
  auto renderer = render::FrameRenderer::create(world.visible(), world.camera(index).camera(),
                                                {.format = camera.format,
                                                 .exposure_taps = camera.exposure_taps,
                                                 .lens_blur_px = camera.lens_blur_px,
                                                 .gain = camera.gain,
                                                 .read_noise_counts = camera.read_noise_counts,
                                                 .shot_noise_gain = camera.shot_noise_gain,
                                                 .noise_seed = world.scene().seed * kMostCameras + index,
                                                 .line_delay_s = camera.line_delay_s});
  ROSEAU_CHECK(renderer.has_value());  // check(scene) refuses what a renderer would
  return std::move(*renderer);
}

}  // namespace

CameraView::CameraView(std::shared_ptr<const World> world, std::size_t camera)
    : world_(std::move(world)), index_(camera), renderer_(make_renderer(*world_, camera)) {}

void CameraView::render(std::uint64_t frame, double midpoint_s, std::span<std::byte> pixels) {
  const double duration_s = camera().exposure_duration_s;
  renderer_.render(
      frame, midpoint_s - duration_s / 2, duration_s,
      [this](double time_s, render::SceneMoment& moment) { world_->fill_moment(time_s, amplitudes_, moment); }, pixels);
}

Frame CameraView::take(std::uint64_t frame, double midpoint_s, FramePool& pool) {
  Frame taken{.pixels = pool.acquire(),
              .width = camera().width_px,
              .height = camera().height_px,
              .stride = static_cast<std::uint32_t>(renderer_.row_bytes()),
              .format = camera().format,
              .exposure_duration = from_seconds(camera().exposure_duration_s)};
  if (taken.pixels) render(frame, midpoint_s, taken.pixels.writable_bytes());
  return taken;
}

}  // namespace roseau::synthesis
