#include "synthesis/rig/simulated_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace roseau::synthesis {

namespace {
constexpr std::size_t kBuffers = 48;  // a second and a half at 30 frames per second
constexpr std::uint64_t kCameraStreams = 1000;
}  // namespace

SimulatedCamera::SimulatedCamera(std::shared_ptr<const World> world, std::size_t index)
    : world_(std::move(world)),
      index_(index),
      name_(fmt::format("camera{}", index)),
      times_(camera().rate_hz, camera().timing, world_->scene.seed, kCameraStreams + index),
      renderer_(world_->scene, index),
      branch_(world_->branch_motion()),
      pool_(kBuffers, renderer_.frame_bytes()),
      taps_m_(static_cast<std::size_t>(camera().exposure_taps)),
      frames_per_calibration_(static_cast<std::uint64_t>(std::max(1.0, std::round(camera().rate_hz)))) {
  go_to(0);
}

void SimulatedCamera::declare(StreamTable& streams) {
  image_stream_ = streams.add({.topic = fmt::format("/{}/image", name_),
                               .kind = std::string(to_string(SampleKind::frame)),
                               .device = name_,
                               .metadata = {{"rate_hz", fmt::format("{}", camera().rate_hz)}, {"link", "simulated"}}});
  calibration_stream_ = streams.add({.topic = fmt::format("/{}/calibration", name_),
                                     .kind = std::string(to_string(SampleKind::camera_calibration)),
                                     .device = name_});
}

void SimulatedCamera::go_to(std::uint64_t frame) {
  frame_ = frame;
  const double ready_s = times_.sample_time_s(frame) + camera().exposure_duration_s / 2 + times_.delay_s(frame);
  next_arrival_ = std::max(next_arrival_, from_seconds(ready_s));
}

void SimulatedCamera::lose_before(Duration time) {
  const std::uint64_t first = times_.first_from(to_seconds(time));
  if (first > frame_) go_to(first);
}

SampleHeader SimulatedCamera::header(StreamId stream, std::uint64_t sequence, HostTime start) const {
  return {.stream = stream,
          .sequence = static_cast<std::uint32_t>(sequence),
          .arrival_time = start + next_arrival_,
          .sample_time = start + from_seconds(times_.sample_time_s(frame_))};
}

void SimulatedCamera::render(std::span<std::byte> pixels) {
  const double middle_s = times_.sample_time_s(frame_);
  const auto taps = static_cast<double>(taps_m_.size());
  for (std::size_t i = 0; i < taps_m_.size(); ++i) {
    const double share = (static_cast<double>(i) + 0.5) / taps - 0.5;
    taps_m_[i] = branch_.deflection_m(middle_s + share * camera().exposure_duration_s);
  }
  renderer_.render(taps_m_, frame_, pixels);
}

bool SimulatedCamera::produce(HostTime start, SampleSink& sink) {
  FrameLease pixels = pool_.acquire();
  if (!pixels) return false;
  render(pixels.writable_bytes());
  // With the first frame, whichever that is, and then once a second.
  if (const std::uint64_t second = frame_ / frames_per_calibration_; last_calibration_ != second) {
    last_calibration_ = second;
    sink.receive({header(calibration_stream_, second, start), renderer_.calibration()});
  }
  sink.receive({header(image_stream_, frame_, start), Frame{.pixels = std::move(pixels),
                                                            .width = camera().width_px,
                                                            .height = camera().height_px,
                                                            .stride = static_cast<std::uint32_t>(renderer_.row_bytes()),
                                                            .format = camera().format,
                                                            .exposure_duration = from_seconds(camera().exposure_duration_s)}});
  go_to(frame_ + 1);
  return true;
}

}  // namespace roseau::synthesis
