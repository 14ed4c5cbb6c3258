#include "synthesis/rig/simulated_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace roseau::synthesis {

namespace {
constexpr std::size_t kBuffers = 48;  // a second and a half at 30 frames per second
}  // namespace

SimulatedCamera::SimulatedCamera(std::shared_ptr<const World> world, std::size_t index)
    : world_(std::move(world)),
      index_(index),
      name_(fmt::format("camera{}", index)),
      times_(world_->camera_times(index)),
      view_(world_, index),
      pool_(kBuffers, view_.frame_bytes()),
      frames_per_calibration_(static_cast<std::uint64_t>(std::max(1.0, std::round(camera().rate_hz)))) {
  // OPENCV8 has three numbers more than the message has room for: then it says pinhole and the model's focal length only.
  if (auto calibration = calib::to_calibration(world_->camera(index).camera())) {
    calibration_ = *calibration;
  } else {
    calib::CameraModel undistorted = world_->camera(index).camera();
    undistorted.lens = calib::Lens::pinhole;
    calibration_ = *calib::to_calibration(undistorted);
  }
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
  while (times_.is_dropped(frame) || times_.is_pulled(times_.sample_time_s(frame))) ++frame;
  frame_ = frame;
  const double ready_s = times_.sample_time_s(frame) + camera().exposure_duration_s / 2 + times_.delay_s(frame);
  next_arrival_ = std::max(next_arrival_, from_seconds(ready_s));
}

void SimulatedCamera::lose_before(Duration time) {
  const std::uint64_t first = times_.first_from(to_seconds(time));
  if (first > frame_) go_to(first);
}

SampleHeader SimulatedCamera::header(StreamId stream, std::uint64_t sequence, HostTime start) const {
  const double midpoint_s = times_.sample_time_s(frame_);
  SampleHeader header{.stream = stream,
                      .sequence = static_cast<std::uint32_t>(sequence),
                      .arrival_time = start + next_arrival_,
                      .sample_time = start + from_seconds(midpoint_s)};
  if (camera().stamps == "device") {
    header.sample_time = header.arrival_time;  // all that the host knows by itself
    header.device_time = DeviceTime{from_seconds(times_.clock().device_time_s(midpoint_s))};
  }
  return header;
}

std::optional<Error> SimulatedCamera::fault_at(Duration time) const {
  if (!times_.is_pulled(to_seconds(time))) return std::nullopt;
  return Error{ErrorCode::disconnected, name_ + ": the camera is gone: check its cable"};
}

bool SimulatedCamera::produce(HostTime start, SampleSink& sink) {
  Frame frame = view_.take(frame_, times_.sample_time_s(frame_), pool_);
  if (!frame.pixels) return false;
  // With the first frame, whichever that is, and then once a second.
  if (const std::uint64_t second = frame_ / frames_per_calibration_; last_calibration_ != second) {
    last_calibration_ = second;
    sink.receive({header(calibration_stream_, second, start), calibration_});
  }
  sink.receive({header(image_stream_, frame_, start), std::move(frame)});
  go_to(frame_ + 1);
  return true;
}

}  // namespace roseau::synthesis
