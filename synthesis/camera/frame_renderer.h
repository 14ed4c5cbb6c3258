// FrameRenderer: the pictures of one camera of a scene. What does not move is painted once; a frame then costs the branch's
// region and the noise.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/sample.h"
#include "synthesis/camera/branch_warp.h"
#include "synthesis/camera/sensor_noise.h"
#include "synthesis/scene.h"

namespace roseau::synthesis {

class FrameRenderer {
 public:
  /// The camera is scene.cameras[camera_index]; formats bgr8, rgb8 and mono8. Takes some hundred milliseconds.
  FrameRenderer(const Scene& scene, std::size_t camera_index);

  /// Frame number `frame` as the mean over these deflections of the branch (the taps of the exposure), with its noise. Rows lie
  /// row_bytes() apart. A function of the scene and the arguments. One thread at a time.
  void render(std::span<const double> deflections_m, std::uint64_t frame, std::span<std::byte> pixels);

  std::size_t row_bytes() const { return row_bytes_; }
  std::size_t frame_bytes() const { return row_bytes_ * calibration_.height; }
  const CameraCalibration& calibration() const { return calibration_; }

 private:
  CameraCalibration calibration_;
  std::size_t row_bytes_;
  cv::Mat backdrop_;  // in the frame's format
  BranchWarp branch_;
  SensorNoise noise_;
  std::vector<std::uint8_t> row_;
};

}  // namespace roseau::synthesis
