// SimulatedCamera: frames of the scene and, once a second, the camera's calibration.
#pragma once

#include <memory>
#include <vector>

#include "synthesis/camera/frame_renderer.h"
#include "synthesis/rig/simulated_device.h"
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

 private:
  const CameraScene& camera() const { return world_->scene.cameras[index_]; }
  void go_to(std::uint64_t frame);
  void render(std::span<std::byte> pixels);
  SampleHeader header(StreamId stream, std::uint64_t sequence, HostTime start) const;

  std::shared_ptr<const World> world_;
  std::size_t index_;
  std::string name_;
  SampleTimes times_;
  FrameRenderer renderer_;
  BranchMotion branch_;
  FramePool pool_;
  std::vector<double> taps_m_;

  StreamId image_stream_ = 0;
  StreamId calibration_stream_ = 0;
  std::uint64_t frame_ = 0;
  Duration next_arrival_{0};
  std::uint64_t frames_per_calibration_;
  std::optional<std::uint64_t> last_calibration_;  // which second's
};

}  // namespace roseau::synthesis
