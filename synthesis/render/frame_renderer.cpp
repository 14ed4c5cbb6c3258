#include "synthesis/render/frame_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/check.h"
#include "synthesis/render/backdrop.h"
#include "synthesis/render/coverage.h"
#include "synthesis/render/scene_painter.h"
#include "synthesis/render/sensor.h"

namespace roseau::render {

namespace {

constexpr std::uint32_t kSmallest_px = 16;
constexpr std::uint32_t kLargest_px = 16384;

Error wrong(const std::string& what) { return {ErrorCode::invalid_argument, fmt::format("camera: {}", what)}; }

Result<void> check_options(const CameraOptions& options) {
  const auto from_to = [](double value, double low, double high) { return value >= low && value <= high; };
  if (options.format == PixelFormat::mono16) return wrong("pictures are drawn as mono8, bgr8 or rgb8, not as mono16");
  if (options.exposure_taps < 1 || options.exposure_taps > 64) return wrong("exposure_taps must be 1 to 64");
  if (!from_to(options.lens_blur_px, 0, 5)) return wrong("lens_blur_px must be 0 to 5");
  if (!from_to(options.gain, 0.01, 100)) return wrong("gain must be 0.01 to 100");
  if (!from_to(options.read_noise_counts, 0, 50)) return wrong("read_noise_counts must be 0 to 50");
  if (!from_to(options.shot_noise_gain, 0, 10)) return wrong("shot_noise_gain must be 0 to 10");
  if (!from_to(options.line_delay_s, 0, 0.01)) return wrong("line_delay_s must be 0 to 0.01");
  if (options.band_rows == 0) return wrong("band_rows must be at least 1");
  return {};
}

// Adds up exposure taps.
class TapSum {
 public:
  explicit TapSum(std::size_t size) : sums_(size) {}
  void clear() { std::ranges::fill(sums_, 0U); }
  void add(const Picture& picture) {
    for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] += picture.steps[i];
  }
  void mean(unsigned taps, Picture& picture) const {
    for (std::size_t i = 0; i < sums_.size(); ++i) picture.steps[i] = static_cast<std::uint16_t>((sums_[i] + taps / 2) / taps);
  }

 private:
  std::vector<std::uint32_t> sums_;
};

}  // namespace

struct FrameRenderer::Workshop {
  Workshop(std::shared_ptr<const VisibleScene> its_scene, const calib::CameraModel& camera, const CameraOptions& its_options)
      : scene(std::move(its_scene)),
        options(its_options),
        projection(camera),
        ink(options.format),
        picture(static_cast<int>(camera.width), static_cast<int>(camera.height), ink.channels()),
        backdrop(*scene, projection, ink),
        painter(*scene, projection, ink),
        coverage(picture.width, picture.height),
        sensor(options, picture.width, picture.height, ink.channels()),
        taps(options.exposure_taps > 1 ? picture.steps.size() : 0),
        moment(scene->rest()) {}

  void draw_tap(double tap_start_s, double tap_share, double duration_s, const MomentAt& moment_at);
  void draw_band(int top, int bottom, double time_s, double board_start_s, double duration_s);

  std::shared_ptr<const VisibleScene> scene;
  CameraOptions options;
  calib::Projection projection;
  InkMaker ink;
  Picture picture;
  Backdrop backdrop;
  ScenePainter painter;
  Coverage coverage;
  Sensor sensor;
  TapSum taps;
  SceneMoment moment;
};

// Rows [top, bottom) as they are at `moment`, the scene's state at `time_s`. `board_start_s`: scene time at which row 0 begins
// its exposure, whichever tap this is: the board is integrated exactly.
void FrameRenderer::Workshop::draw_band(int top, int bottom, double time_s, double board_start_s, double duration_s) {
  BoardExposure board;
  if (scene->description().led_board) {
    const double tick_s = scene->description().led_board->tick_duration_s;
    // The board's clock runs off by some ten parts per million at most: nothing over an exposure.
    board = {.start_ticks = (moment.board_time_s - (time_s - board_start_s)) / tick_s,
             .ticks_per_row = options.line_delay_s / tick_s,
             .duration_ticks = duration_s / tick_s};
  }
  painter.pose(moment, board);
  painter.draw(coverage, picture, {0, top, picture.width, bottom});
}

void FrameRenderer::Workshop::draw_tap(double start_s, double tap_share, double duration_s, const MomentAt& moment_at) {
  const bool rolling = options.line_delay_s > 0;
  const int rows = rolling ? static_cast<int>(std::min(options.band_rows, kLargest_px)) : picture.height;
  const auto time_of_row = [&](double row) { return start_s + tap_share * duration_s + options.line_delay_s * row; };
  for (int top = 0; top < picture.height; top += rows) {
    const int bottom = std::min(top + rows, picture.height);
    const double band_s = time_of_row((top + bottom - 1) / 2.0);
    moment_at(band_s, moment);
    // The landscape moves too slowly to be drawn in bands.
    if (top == 0) backdrop.paint(time_of_row((picture.height - 1) / 2.0), moment.background_sway, picture);
    draw_band(top, bottom, band_s, start_s, duration_s);
  }
}

Result<FrameRenderer> FrameRenderer::create(std::shared_ptr<const VisibleScene> scene, const calib::CameraModel& camera,
                                            const CameraOptions& options) {
  ROSEAU_CHECK(scene != nullptr);
  if (const Result<void> checked = calib::check(camera); !checked) return checked.error();
  if (std::min(camera.width, camera.height) < kSmallest_px || std::max(camera.width, camera.height) > kLargest_px) {
    return wrong(fmt::format("a picture of {} x {} px cannot be drawn: sides must have {} to {} px", camera.width,
                             camera.height, kSmallest_px, kLargest_px));
  }
  if (const Result<void> checked = check_options(options); !checked) return checked.error();
  return FrameRenderer(std::make_unique<Workshop>(std::move(scene), camera, options));
}

FrameRenderer::FrameRenderer(std::unique_ptr<Workshop> workshop) : workshop_(std::move(workshop)) {}
FrameRenderer::FrameRenderer(FrameRenderer&&) noexcept = default;
FrameRenderer& FrameRenderer::operator=(FrameRenderer&&) noexcept = default;
FrameRenderer::~FrameRenderer() = default;

void FrameRenderer::render(std::uint64_t frame, double exposure_start_s, double exposure_duration_s, const MomentAt& moment_at,
                           std::span<std::byte> pixels) {
  ROSEAU_CHECK(exposure_duration_s > 0 && pixels.size() >= frame_bytes());
  Workshop& w = *workshop_;
  const int taps = w.options.exposure_taps;
  if (taps > 1) w.taps.clear();
  for (int tap = 0; tap < taps; ++tap) {
    w.draw_tap(exposure_start_s, (tap + 0.5) / taps, exposure_duration_s, moment_at);
    if (taps > 1) w.taps.add(w.picture);
  }
  if (taps > 1) w.taps.mean(static_cast<unsigned>(taps), w.picture);
  w.sensor.read_out(w.picture, w.moment.light_level, frame, pixels);
}

std::size_t FrameRenderer::row_bytes() const { return workshop_->picture.row_size(); }
std::size_t FrameRenderer::frame_bytes() const { return workshop_->picture.steps.size(); }
const calib::CameraModel& FrameRenderer::camera() const { return workshop_->projection.camera(); }
const CameraOptions& FrameRenderer::options() const { return workshop_->options; }

}  // namespace roseau::render
