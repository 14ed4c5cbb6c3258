#include "recorder/tools/export/sample_table.h"

#include <fmt/format.h>

#include <array>

#include "core/check.h"

namespace roseau::recorder {

namespace {

using Row = std::vector<Field>;
using Rows = std::vector<Row>;

template <class T>
  requires std::is_integral_v<T>
Field field(T value) {
  return static_cast<std::int64_t>(value);
}
Field field(double value) { return value; }
Field field(const std::string& value) { return value; }
Field field(std::string_view value) { return std::string(value); }

template <class... Values>
Row row(const Values&... values) {
  return {field(values)...};
}

/// Bytes as text: what is printable as it is, the rest as \x02.
std::string escaped(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte byte : bytes) {
    const auto c = std::to_integer<unsigned char>(byte);
    if (c == '\\') {
      text += "\\\\";
    } else if (c >= 0x20 && c < 0x7F) {
      text += static_cast<char>(c);
    } else {
      text += fmt::format("\\x{:02x}", c);
    }
  }
  return text;
}

std::string_view name_of(OperatorAction::Kind kind) {
  constexpr std::array<std::string_view, 7> kNames = {"mark",           "add_target", "remove_target", "start_recording",
                                                      "stop_recording", "note",       "trigger"};
  return kNames.at(static_cast<std::size_t>(kind));
}

std::string_view name_of(LedBoardTime::Event event) {
  constexpr std::array<std::string_view, 5> kNames = {"latch", "rising_edge", "falling_edge", "question_received",
                                                      "answer_sent"};
  return kNames.at(static_cast<std::size_t>(event));
}

// In the order of columns_of.

Rows rows(const RawBytes& raw) { return {row(raw.size, escaped(raw.bytes()), raw.line_errors, to_seconds(raw.byte_time))}; }
Rows rows(const Frame& frame) {
  return {row(frame.width, frame.height, to_string(frame.format), to_seconds(frame.exposure_duration))};
}
Rows rows(const CameraCalibration& camera) {
  Row values = row(camera.width, camera.height, camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px);
  for (const double k : camera.distortion) values.emplace_back(k);
  for (const double r : camera.rotation_camera_from_world) values.emplace_back(r);
  const Vec3& at = camera.position_in_world_m;
  for (const double coordinate : {at.x, at.y, at.z}) values.emplace_back(coordinate);
  return {values};
}
Rows rows(const OperatorAction& action) {
  const ImageRect& r = action.region;
  return {row(name_of(action.kind), action.text, action.camera, r.x, r.y, r.width, r.height)};
}
Rows rows(const Skip& skip) { return {row(skip.stream, skip.sequence)}; }
Rows rows(const WindSample& wind) {
  return {row(wind.u_mps, wind.v_mps, wind.w_mps, wind.sonic_temperature_celsius, wind.speed_of_sound_mps, wind.device_status,
              wind.valid)};
}
Rows rows(const Displacement& d) {
  return {row(d.x, d.y, to_string(d.unit), d.covariance.xx, d.covariance.xy, d.covariance.yy, d.region.x, d.region.y,
              d.region.width, d.region.height, d.features, static_cast<double>(d.health), d.valid)};
}
Rows rows(const ImageMotion& motion) {
  Rows all;
  for (const auto& point : motion.points) {
    const std::string target = point.target < motion.targets.size() ? motion.targets[point.target].name : "";
    all.push_back(row(target, static_cast<double>(point.x), static_cast<double>(point.y), static_cast<double>(point.dx),
                      static_cast<double>(point.dy), point.good));
  }
  return all;
}
Rows rows(const Identification& id) {
  return {row(id.natural_frequency_hz, id.natural_frequency_sd_hz, id.damping_ratio, id.damping_ratio_sd, id.noise_sd,
              id.force_slope, id.peak_to_floor, id.axis.x, id.axis.y, id.window_s, id.accepted)};
}
Rows rows(const WindEstimate& e) {
  return {
      row(e.wind_mps, e.wind_sd_mps, e.force_per_mass, e.force_per_mass_sd, e.lag_s, e.accepted, e.settling, e.scale_known)};
}
Rows rows(const WindCalibration& c) {
  return {row(c.reference, c.gain, c.offset, c.exponent, c.delay_s, c.direction_deg, c.explained, c.correlation, c.rms_mps,
              c.seconds_used)};
}
Rows rows(const ForceSpectrum& s) {
  const auto at = [](const std::vector<float>& values, std::size_t i) {
    return i < values.size() ? static_cast<double>(values[i]) : kNotMeasured;
  };
  Rows all;
  for (std::size_t i = 0; i < s.frequency_hz.size(); ++i) {
    all.push_back(row(at(s.frequency_hz, i), at(s.displacement_power, i), at(s.model_power, i), at(s.force_power, i),
                      at(s.force_noise_power, i), static_cast<double>(s.trust_low_hz), static_cast<double>(s.trust_high_hz)));
  }
  return all;
}
Rows rows(const ClockState& c) {
  return {row(c.device, c.offset_s, c.offset_sd_s, c.frequency_offset_ppm, c.jitter_s, c.samples, c.resets)};
}
Rows rows(const Gap& gap) { return {row(gap.topic, gap.missing, gap.expected_sequence)}; }
Rows rows(const Drop& drop) { return {row(drop.topic, drop.stage, drop.count)}; }
Rows rows(const Health& health) {
  Rows all;
  for (const auto& stream : health.streams) {
    const StreamCounters& c = stream.counters;
    all.push_back(row(std::string("stream"), stream.topic, c.received, c.recorded, c.dropped, c.gaps, c.bad, c.late,
                      stream.rate_hz, stream.age_s, std::string(), std::string()));
  }
  for (const auto& device : health.devices) {
    all.push_back(row(std::string("device"), device.name, 0, 0, 0, 0, 0, 0, kNotMeasured, kNotMeasured, to_string(device.state),
                      device.message));
  }
  return all;
}
Rows rows(const LogEntry& entry) {
  constexpr std::array<std::string_view, 6> kLevels = {"", "debug", "info", "warning", "error", "fatal"};
  return {row(kLevels.at(static_cast<std::size_t>(entry.level)), entry.name, entry.message)};
}
Rows rows(const StationPose& pose) {
  const Vec3& p = pose.position_in_source_m;
  const Quaternion& q = pose.source_from_station;
  return {row(pose.station, p.x, p.y, p.z, q.w, q.x, q.y, q.z, pose.device_status, pose.valid)};
}
Rows rows(const LedBoardTime& board) { return {row(name_of(board.event), board.tick, board.microseconds, board.sequence)}; }
Rows rows(const MarkerPositions& positions) {
  Rows all;
  for (const auto& marker : positions.markers) {
    const Covariance3 c = marker.covariance_m2.value_or(
        Covariance3{kNotMeasured, kNotMeasured, kNotMeasured, kNotMeasured, kNotMeasured, kNotMeasured});
    const Vec3& p = marker.position_m;
    all.push_back(row(marker.name, positions.frame, p.x, p.y, p.z, c.xx, c.xy, c.xz, c.yy, c.yz, c.zz));
  }
  return all;
}
Rows rows(const ModalState& modes) {
  const auto at = [](const std::vector<double>& values, std::size_t i) { return i < values.size() ? values[i] : kNotMeasured; };
  Rows all;
  for (std::size_t i = 0; i < modes.natural_frequency_hz.size(); ++i) {
    all.push_back(row(modes.structure, i + 1, modes.natural_frequency_hz[i], at(modes.damping_ratio, i), at(modes.amplitude, i),
                      at(modes.modal_force, i)));
  }
  return all;
}

std::vector<Column> camera_columns() {
  std::vector<Column> columns = {{"width_px", "1", "picture width"},         {"height_px", "1", "picture height"},
                                 {"fx_px", "1", "focal length, horizontal"}, {"fy_px", "1", "focal length, vertical"},
                                 {"cx_px", "1", "principal point, x"},       {"cy_px", "1", "principal point, y"}};
  for (const char* name : {"k1", "k2", "p1", "p2", "k3"}) columns.push_back({name, "1", "Brown-Conrady distortion"});
  for (int i = 0; i < 9; ++i) {
    columns.push_back({fmt::format("r{}{}", i / 3 + 1, i % 3 + 1), "1", "rotation, camera from world"});
  }
  for (const char* name : {"x_m", "y_m", "z_m"}) columns.push_back({name, "m", "camera position in world"});
  return columns;
}

const std::array<std::vector<Column>, kSampleKindCount>& all_columns() {
  static const std::array<std::vector<Column>, kSampleKindCount> columns = {{
      {{"size", "1", "bytes in this read"},
       {"bytes", "", "as read; \\x.. in hexadecimal where not printable"},
       {"line_errors", "1", "parity, framing and break errors"},
       {"byte_time_s", "s", "time of one byte on the wire"}},
      {{"width_px", "1", "picture width"},
       {"height_px", "1", "picture height"},
       {"format", "", "pixel format"},
       {"exposure_s", "s", "exposure duration"}},
      camera_columns(),
      {{"action", "", "what was done"},
       {"text", "", "words, or the target's name"},
       {"camera", "", "camera concerned"},
       {"x_px", "1", "region"},
       {"y_px", "1", "region"},
       {"width_px", "1", "region"},
       {"height_px", "1", "region"}},
      {{"skipped_stream", "1", "stream number"}, {"skipped_sequence", "1", "of the sample not analysed"}},
      {{"u_mps", "m s-1", "wind along the instrument's u axis"},
       {"v_mps", "m s-1", "wind along the instrument's v axis"},
       {"w_mps", "m s-1", "wind along the instrument's w axis"},
       {"sonic_temperature_celsius", "degree_Celsius", "sonic temperature"},
       {"speed_of_sound_mps", "m s-1", "speed of sound"},
       {"device_status", "1", "the instrument's status code"},
       {"valid", "1", "1: the wind is usable"}},
      {{"x", "1", "displacement to the right, in the stream's unit"},
       {"y", "1", "displacement down, in the stream's unit"},
       {"unit", "", "of x and y"},
       {"var_xx", "1", "variance of x"},
       {"cov_xy", "1", "covariance of x and y"},
       {"var_yy", "1", "variance of y"},
       {"region_x_px", "1", "where the target is"},
       {"region_y_px", "1", "where the target is"},
       {"region_width_px", "1", "how large the target is"},
       {"region_height_px", "1", "how large the target is"},
       {"features", "1", "points that agreed"},
       {"health", "1", "0: lost, 1: all points agree"},
       {"valid", "1", "0: lost, x and y are the last good values"}},
      {{"target", "", "empty: background"},
       {"x_px", "1", "point, x"},
       {"y_px", "1", "point, y"},
       {"dx_px", "1", "motion since the previous frame, x"},
       {"dy_px", "1", "motion since the previous frame, y"},
       {"good", "1", "1: agreed with its target"}},
      {{"natural_frequency_hz", "Hz", "undamped natural frequency"},
       {"natural_frequency_sd_hz", "Hz", "its standard deviation"},
       {"damping_ratio", "1", "damping ratio"},
       {"damping_ratio_sd", "1", "its standard deviation"},
       {"noise_sd", "1", "noise of one displacement sample"},
       {"force_slope", "1", "p in S_force ~ w^-p"},
       {"peak_to_floor", "1", "resonance peak over noise floor, power"},
       {"axis_x", "1", "main axis of motion"},
       {"axis_y", "1", "main axis of motion"},
       {"window_s", "s", "length of data it rests on"},
       {"accepted", "1", "1: the gate was passed"}},
      {{"wind_mps", "m s-1", "wind along the main axis"},
       {"wind_sd_mps", "m s-1", "its standard deviation"},
       {"force_per_mass", "1", "in displacement unit per s2"},
       {"force_per_mass_sd", "1", "its standard deviation"},
       {"lag_s", "s", "how much later it was known"},
       {"accepted", "1", "1: the identification was accepted"},
       {"settling", "1", "1: not yet settled"},
       {"scale_known", "1", "1: calibrated, so that m/s means m/s"}},
      {{"reference", "", "topic of the reference wind"},
       {"gain", "1", "a in V|V|^(n-1) = a f + b"},
       {"offset", "1", "b"},
       {"exponent", "1", "n"},
       {"delay_s", "s", "reference later than estimate"},
       {"direction_deg", "degree", "horizontal direction (from) compared"},
       {"explained", "1", "1 - MSE / variance"},
       {"correlation", "1", "with the reference"},
       {"rms_mps", "m s-1", "difference"},
       {"seconds_used", "s", "data used"}},
      {{"frequency_hz", "Hz", "frequency"},
       {"displacement_power", "1", "unit2 / Hz"},
       {"model_power", "1", "unit2 / Hz"},
       {"force_power", "1", "(unit / s2)2 / Hz"},
       {"force_noise_power", "1", "(unit / s2)2 / Hz"},
       {"trust_low_hz", "Hz", "band that can be trusted"},
       {"trust_high_hz", "Hz", "band that can be trusted"}},
      {{"device", "", "whose clock"},
       {"offset_s", "s", "host = device + offset"},
       {"offset_sd_s", "s", "its standard deviation"},
       {"frequency_offset_ppm", "1e-6", "device fast: positive"},
       {"jitter_s", "s", "spread of arrivals"},
       {"samples", "1", "it rests on"},
       {"resets", "1", "of the device's clock"}},
      {{"topic", "", "stream concerned"}, {"missing", "1", "samples that never came"}, {"expected_sequence", "1", "the first"}},
      {{"topic", "", "stream concerned"}, {"stage", "", "where"}, {"count", "1", "samples thrown away"}},
      {{"item", "", "stream or device"},
       {"name", "", "topic or device"},
       {"received", "1", "samples"},
       {"recorded", "1", "samples"},
       {"dropped", "1", "samples"},
       {"gaps", "1", "samples"},
       {"bad", "1", "samples"},
       {"late", "1", "samples"},
       {"rate_hz", "Hz", "rate"},
       {"age_s", "s", "since the last sample"},
       {"state", "", "device state"},
       {"message", "", "what is wrong"}},
      {{"level", "", "severity"}, {"name", "", "whom it concerns"}, {"message", "", "what happened"}},
      {{"station", "1", "number"},
       {"x_m", "m", "position in the source's axes"},
       {"y_m", "m", "position in the source's axes"},
       {"z_m", "m", "position in the source's axes"},
       {"qw", "1", "rotation, source from station"},
       {"qx", "1", "rotation, source from station"},
       {"qy", "1", "rotation, source from station"},
       {"qz", "1", "rotation, source from station"},
       {"device_status", "1", "the tracker's error code"},
       {"valid", "1", "1: usable"}},
      {{"event", "", "what happened"},
       {"tick", "1", "the board's counter"},
       {"microseconds", "1e-6 s", "since the tick"},
       {"number", "1", "of the message"}},
      {{"marker", "", "name"},
       {"frame", "", "whose axes"},
       {"x_m", "m", "position"},
       {"y_m", "m", "position"},
       {"z_m", "m", "position"},
       {"var_xx_m2", "m2", "variance of x"},
       {"cov_xy_m2", "m2", "covariance"},
       {"cov_xz_m2", "m2", "covariance"},
       {"var_yy_m2", "m2", "variance of y"},
       {"cov_yz_m2", "m2", "covariance"},
       {"var_zz_m2", "m2", "variance of z"}},
      {{"structure", "", "which"},
       {"mode", "1", "number, from 1"},
       {"natural_frequency_hz", "Hz", "undamped"},
       {"damping_ratio", "1", "damping ratio"},
       {"amplitude", "m kg0.5", "mass-normalised"},
       {"modal_force", "m kg0.5 s-2", "mass-normalised"}},
  }};
  return columns;
}

}  // namespace

const std::vector<Column>& columns_of(SampleKind kind) { return all_columns().at(static_cast<std::size_t>(kind)); }

std::vector<std::vector<Field>> rows_of(const Sample& sample) {
  auto all = std::visit([](const auto& payload) { return rows(payload); }, sample.payload);
  for (const auto& one : all) ROSEAU_CHECK(one.size() == columns_of(sample.kind()).size());
  return all;
}

}  // namespace roseau::recorder
