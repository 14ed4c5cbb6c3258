// SimulatedCamera: frames of the scene and, once a second, the camera's calibration.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "synthesis/instruments/simulated_device.h"
#include "synthesis/rig/camera_view.h"
#include "synthesis/rig/world.h"

namespace roseau::synthesis {

/// Streams: /cameraN/image (sequence = frame number, so that a lost frame shows as a gap) and /cameraN/calibration.
class SimulatedCamera final : public SimulatedDevice {
 public:
  SimulatedCamera(std::shared_ptr<const World> world, std::size_t index);

  const std::string& name() const override { return name_; }
  void declare(StreamTable& streams) override;
  Due next() const override { return {next_arrival_, next_arrival_}; }
  bool produce(HostTime start, SampleSink& sink) override;
  void lose_before(Duration time) override;
  void lose_next() override { go_to(frame_ + 1); }
  std::optional<Error> fault_at(Duration time) const override;

 private:
  const CameraScene& camera() const { return world_->scene().cameras[index_]; }
  void go_to(std::uint64_t frame);
  SampleHeader header(StreamId stream, std::uint64_t sequence, HostTime start) const;

  std::shared_ptr<const World> world_;
  std::size_t index_;
  std::string name_;
  SampleTimes times_;
  CameraView view_;
  FramePool pool_;
  CameraCalibration calibration_;

  StreamId image_stream_ = 0;
  StreamId calibration_stream_ = 0;
  std::uint64_t frame_ = 0;
  Duration next_arrival_{0};
  std::uint64_t frames_per_calibration_;
  std::optional<std::uint64_t> last_calibration_;  // which second's
};

}  // namespace roseau::synthesis
