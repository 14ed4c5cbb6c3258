// FrameRenderer: the pictures of one camera of a scene. Edges are drawn by the exact share of each pixel that a shape covers,
// so that everything stands where the camera model puts it, to a few thousandths of a pixel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "calib/model/camera_model.h"
#include "core/result.h"
#include "synthesis/render/camera_options.h"
#include "synthesis/render/scene_moment.h"
#include "synthesis/render/visible_scene.h"

namespace roseau::render {

class FrameRenderer {
 public:
  /// Refuses a model that fails calib::check(), pictures larger than 16384 pixels a side, other formats than mono8, bgr8 and
  /// rgb8, and options out of range, naming them. Takes some hundred milliseconds: the backdrop is painted here.
  static Result<FrameRenderer> create(std::shared_ptr<const VisibleScene> scene, const calib::CameraModel& camera,
                                      const CameraOptions& options);
  FrameRenderer(FrameRenderer&&) noexcept;
  FrameRenderer& operator=(FrameRenderer&&) noexcept;
  ~FrameRenderer();

  /// Picture number `frame`, exposed from `exposure_start_s` (of its first row) for `exposure_duration_s` (above 0).
  /// `moment_at` is asked for the scene once per exposure tap, at ascending times within the exposure; with a rolling shutter
  /// once per tap and band, from the first band on for each tap. Rows lie row_bytes() apart. The result is a function of the
  /// scene, the camera and these arguments alone; frames may be made in any order. Allocates nothing once the first frames are
  /// made. One thread at a time.
  void render(std::uint64_t frame, double exposure_start_s, double exposure_duration_s, const MomentAt& moment_at,
              std::span<std::byte> pixels);

  std::size_t row_bytes() const;
  std::size_t frame_bytes() const;
  const calib::CameraModel& camera() const;
  const CameraOptions& options() const;

 private:
  struct Workshop;
  explicit FrameRenderer(std::unique_ptr<Workshop> workshop);
  std::unique_ptr<Workshop> workshop_;
};

}  // namespace roseau::render
