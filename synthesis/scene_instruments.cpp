#include "synthesis/scene_instruments.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "drivers/wire/fastrak.h"

namespace roseau::synthesis {

namespace {

// From, to, from, to, ...: seconds of the scene.
void describe_intervals(SceneFields& fields, std::string_view key, std::vector<double>& times_s) {
  fields.numbers(key, times_s);
  fields.require(times_s.size() % 2 == 0 && std::ranges::is_sorted(times_s) && (times_s.empty() || times_s.front() >= 0), key,
                 "must be pairs of times, from and to, ascending");
}

void describe_line(SceneFields& fields, double& baud, double& split_probability, double& byte_error_probability) {
  fields.number("baud", baud, 300, 4e6);
  fields.number("split_probability", split_probability, 0, 1);
  fields.number("byte_error_probability", byte_error_probability, 0, 0.5);
}

}  // namespace

void describe_timing(SceneFields& fields, DeviceTiming& timing) {
  fields.number("frequency_offset_ppm", timing.frequency_offset_ppm, -10000, 10000);
  fields.number("start_offset_s", timing.start_offset_s, 0, 1e6);
  fields.number("latency_s", timing.latency_s, 0, 10);
  fields.number("jitter_s", timing.jitter_s, 0, 1);
  fields.number("counter_offset_s", timing.counter_offset_s, 0, 1e9);
  fields.number("wander_ppm", timing.wander_ppm, 0, 1000);
  fields.number("wander_time_s", timing.wander_time_s, 1, 1e6);
  fields.number("spike_probability", timing.spike_probability, 0, 1);
  fields.number("spike_s", timing.spike_s, 0, 10);
  fields.number("drop_probability", timing.drop_probability, 0, 0.9);
  fields.number("drop_burst", timing.drop_burst, 1, 100);
  describe_intervals(fields, "cable_pulls_s", timing.cable_pulls_s);
}

void describe_sonic(SceneFields& fields, SonicOptions& sonic) {
  constexpr double kBitsPerRecord = 530;  // 53 bytes of 10 bits
  fields.point("position_in_world_m", sonic.position_in_world_m);
  fields.number("north_offset_deg", sonic.north_offset_deg, -360, 360);
  fields.number("tilt_about_u_deg", sonic.tilt_about_u_deg, -90, 90);
  fields.number("tilt_about_v_deg", sonic.tilt_about_v_deg, -90, 90);
  fields.number("rate_hz", sonic.rate_hz, 1, 32);
  fields.require(is_wind_master_rate(sonic.rate_hz), "rate_hz", "must be one of a WindMaster's: 1, 2, 4, 5, 8, 10, 16, 20, 32");
  describe_line(fields, sonic.baud, sonic.split_probability, sonic.byte_error_probability);
  fields.require(sonic.baud >= kBitsPerRecord * sonic.rate_hz, "baud",
                 fmt::format("must be at least {} for {} records a second", kBitsPerRecord * sonic.rate_hz, sonic.rate_hz));
  fields.number("noise_mps", sonic.noise_mps, 0, 10);
  fields.number("air_temperature_celsius", sonic.air_temperature_celsius, -60, 60);
  fields.number("temperature_noise_celsius", sonic.temperature_noise_celsius, 0, 10);
  fields.flag("averages_paths", sonic.averages_paths);
  fields.number("path_length_m", sonic.path_length_m, 0.001, 10);
  fields.number("range_mps", sonic.range_mps, 0.1, 100);
  fields.flag("high_resolution", sonic.high_resolution);
  fields.number("fault_probability", sonic.fault_probability, 0, 1);
  fields.number("marginal_probability", sonic.marginal_probability, 0, 1);
  describe_intervals(fields, "fault_intervals_s", sonic.fault_intervals_s);
  describe_timing(fields, sonic.timing);
}

void describe_tracker(SceneFields& fields, TrackerScene& scene) {
  static constexpr std::array<std::string_view, 2> kUnits{"cm", "inch"};
  MagneticTrackerOptions& tracker = scene.instrument;
  fields.flag("enabled", scene.enabled);
  fields.whole("station_count", tracker.station_count, 1, 4);
  fields.point("source_position_in_world_m", tracker.source_position_in_world_m);
  fields.point("source_angles_deg", tracker.source_angles_deg);
  fields.flag("is_binary", tracker.is_binary);
  fields.text("items", tracker.items);
  fields.word("unit", tracker.unit, kUnits);
  if (const auto layout = wire::FastrakLayout::parse(tracker.items); !layout) {
    fields.require(false, "items", layout.error().message);
  }
  describe_line(fields, tracker.baud, tracker.split_probability, tracker.byte_error_probability);
  fields.number("noise_m", tracker.noise_m, 0, 1);
  fields.number("noise_deg", tracker.noise_deg, 0, 90);
  fields.number("noise_range_m", tracker.noise_range_m, 0.01, 100);
  fields.number("noise_exponent", tracker.noise_exponent, 0, 8);
  fields.number("noise_floor_m", tracker.noise_floor_m, 0, 1);
  fields.number("noise_floor_deg", tracker.noise_floor_deg, 0, 90);
  fields.number("distortion_m", tracker.distortion_m, 0, 1);
  fields.number("distortion_deg", tracker.distortion_deg, 0, 90);
  fields.number("distortion_length_m", tracker.distortion_length_m, 0.01, 100);
  fields.number("range_m", tracker.range_m, 0.1, 100);
  fields.point("hemisphere_in_source", tracker.hemisphere_in_source);
  fields.number("error_probability", tracker.error_probability, 0, 1);
  describe_timing(fields, tracker.timing);
}

void describe_led_board(SceneFields& fields, LedBoardScene& scene) {
  LedBoardOptions& board = scene.instrument;
  fields.flag("enabled", scene.enabled);
  fields.point("centre_in_world_m", scene.centre_in_world_m);
  fields.number("pitch_m", scene.pitch_m, 0.005, 1);
  fields.number("tick_s", board.tick_s, 1e-5, 0.1);
  describe_line(fields, board.baud, board.split_probability, board.byte_error_probability);
  describe_timing(fields, board.timing);
}

}  // namespace roseau::synthesis
