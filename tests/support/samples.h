// One sample of every kind with every field set to something that is not its default: for tests of whatever carries samples.
#pragma once

#include <cmath>
#include <cstring>
#include <string>

#include "core/check.h"
#include "core/frame.h"
#include "core/sample.h"
#include "core/stream.h"

namespace roseau::testing {

inline Frame filled_frame(FramePool& pool, std::uint32_t width = 5, std::uint32_t height = 3, std::uint32_t stride = 8) {
  Frame frame{.width = width, .height = height, .stride = stride, .exposure_duration = Duration{4'000'000}};
  ROSEAU_CHECK(pool.buffer_bytes() >= std::size_t{stride} * height);
  frame.pixels = pool.acquire();
  ROSEAU_CHECK(frame.pixels);
  std::byte value{7};
  for (std::byte& pixel : frame.pixels.writable_bytes())
    pixel = value = static_cast<std::byte>(static_cast<int>(value) * 5 + 3);
  return frame;
}

inline RawBytes raw_bytes_of(std::string_view text) {
  RawBytes raw;
  ROSEAU_CHECK(text.size() <= RawBytes::kCapacity);
  std::memcpy(raw.storage.data(), text.data(), text.size());
  raw.size = static_cast<std::uint16_t>(text.size());
  return raw;
}

/// Header of the stream named after the kind ("/test/wind"), which is added to `streams`.
inline SampleHeader filled_header(SampleKind kind, StreamTable& streams) {
  const std::string name(to_string(kind));
  SampleHeader header;
  header.stream = streams.add({.topic = "/test/" + name, .kind = name, .device = "camera0"});
  header.status = kStatusLate | kStatusIncomplete;
  header.sequence = 4'000'000'000;
  header.arrival_time = host_time_from_ns(123'456'789'012'345);
  header.sample_time = host_time_from_ns(123'456'700'000'001);
  header.device_time = device_time_from_ns(-1'500'000'000);
  return header;
}

inline Payload filled_payload(SampleKind kind, StreamTable& streams, FramePool& pool) {
  switch (kind) {
    case SampleKind::raw_bytes: {
      RawBytes raw = raw_bytes_of("\x02Q,229,002.74,M,00,\x03");
      raw.line_errors = 3;
      raw.byte_time = Duration{86'806};
      return raw;
    }
    case SampleKind::frame:
      return filled_frame(pool);
    case SampleKind::camera_calibration:
      return CameraCalibration{.width = 1280,
                               .height = 1024,
                               .fx_px = 1500.5,
                               .fy_px = 1501.5,
                               .cx_px = 640.25,
                               .cy_px = 512.75,
                               .distortion = {-0.1, 0.02, 0.001, -0.002, 0.003},
                               .rotation_camera_from_world = {0, 1, 0, 0, 0, 1, 1, 0, 0},
                               .position_in_world_m = {1, -2, 3.5}};
    case SampleKind::operator_action:
      return OperatorAction{OperatorAction::Kind::add_target, "branch", "camera0", {10, 20, 30, 40}};
    case SampleKind::skip:
      return Skip{streams.add({.topic = "/camera0/image", .kind = "frame"}), 17};
    case SampleKind::wind:
      return WindSample{1.5, -2.5, 0.25, 21.125, 343.5, 60, true};
    case SampleKind::displacement:
      return Displacement{1.25, -0.5, {0.01, -0.002, 0.03}, LengthUnit::strain, {1, 2, 3, 4}, 250, 0.75F, true};
    case SampleKind::image_motion:
      return ImageMotion{{{100.5F, 50.25F, 0.5F, -0.25F, 0, true},
                          {110.5F, 51.25F, 4.5F, 1.25F, 0, false},
                          {10, 20, 0.125F, 0, ImageMotion::kBackground, true}},
                         {{"branch", {90, 40, 30, 20}, 0.9F, true}}};
    case SampleKind::identification:
      return Identification{2.25, 0.01, 0.05, 0.004, 0.1, 1.5, 40, {0.8, 0.6}, 60, true};
    case SampleKind::wind_estimate:
      return WindEstimate{3.5, 0.25, 12.5, 1.5, 0.25, true, true, true};
    case SampleKind::wind_calibration:
      return WindCalibration{"/sonic/wind", 0.5, -0.25, 2, 0.125, 270, 0.875, 0.9375, 0.375, 120};
    case SampleKind::force_spectrum:
      return ForceSpectrum{{0.5F, 1, 1.5F}, {1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}, 0.25F, 8};
    case SampleKind::clock_state:
      return ClockState{"camera0", -12.5, 0.00025, 35.5, 0.0005, 9'000'000'000, 2};
    case SampleKind::gap:
      return Gap{"/camera0/image", 3, 1001};
    case SampleKind::drop:
      return Drop{"/camera0/image", "recorder", 5'000'000'000};
    case SampleKind::health:
      return Health{{{"/sonic/raw", {1, 2, 3, 4, 5, 6}, 20.5, 0.05}},
                    {{"sonic", DeviceState::reopening, "/dev/ttyUSB0 is gone: plug it in"}},
                    DeviceState::degraded,
                    "the disk is full",
                    "/data/a.mcap",
                    61.5,
                    70'000'000'000,
                    80'000'000'000,
                    RecordingPhase::post_trigger,
                    "trigger gust",
                    12.5,
                    3,
                    90'000'000'000,
                    2.5e8,
                    320,
                    9.5,
                    1'000'000'000,
                    17,
                    {"/mnt/second", DeviceState::running, "slow", 60'000'000'000, 10'000'000'000},
                    81.5,
                    true};
    case SampleKind::log:
      return LogEntry{LogEntry::Level::error, "sonic", "no data"};
    case SampleKind::station_pose:
      return StationPose{3, {0.25, -0.5, 0.75}, {0.5, -0.5, 0.5, -0.5}, 'k', true};
    case SampleKind::led_board_time:
      return LedBoardTime{LedBoardTime::Event::rising_edge, 4'000'000'000, 250, 7};
    case SampleKind::marker_positions:
      return MarkerPositions{"world", {{"red", {1, 2, 3}, Covariance3{1, 0.5, 0.25, 2, 0.125, 3}}, {"blue", {4, 5, 6}, {}}}};
    case SampleKind::modal_state:
      return ModalState{"tree", {0.5, 1.5}, {0.05, 0.0625}, {0.25, -0.125}, {2, -1}};
  }
  check_failed("every kind has a sample", __FILE__, __LINE__);
}

inline Sample filled_sample(SampleKind kind, StreamTable& streams, FramePool& pool) {
  return {filled_header(kind, streams), filled_payload(kind, streams, pool)};
}

}  // namespace roseau::testing
