// Every message, described once for writing, reading and clearing (wire.h): field numbers are those of proto/.
// `Io::template Ref<T>` is `const T&` for a Writer and `T&` for the others.
#pragma once

#include <string>
#include <vector>

#include "core/sample.h"
#include "schema/wire.h"

namespace roseau::schema {

/// Numbers of the fields that roseau adds to Foxglove's messages, far from any that Foxglove gives out.
inline constexpr std::uint32_t kHeaderField = 2000;

// ---------------------------------------------------------------------------------------------------------------------
// Messages that differ from their sample's payload

struct RawImageMessage {
  std::string frame_id;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::string encoding;
  std::uint32_t step = 0;
  Duration exposure_duration{0};
  std::span<const std::byte> data;
};

struct CompressedImageMessage {
  std::string frame_id;
  std::string format;
  Duration exposure_duration{0};
  std::string encoding;
  std::span<const std::byte> data;
};

struct CameraCalibrationMessage {
  std::string frame_id;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::vector<double> k;
  std::vector<double> r;
  std::vector<double> p;
  std::vector<double> rotation_camera_from_world;
  Vec3 position_in_world_m;
};

/// A Skip names its stream by topic: ids belong to one run.
struct SkipMessage {
  std::string topic;
  std::uint32_t sequence = 0;
};

struct Pose {
  Vec3 position;
  Quaternion orientation;
};

struct PoseInFrameMessage {
  std::string frame_id;
  Pose pose;
  std::uint8_t station = 0;
  std::uint16_t device_status = 0;
  bool valid = false;
};

struct PosesInFrameMessage {
  struct Marker {
    std::string name;
    bool has_covariance = false;
    Covariance3 covariance_m2;
  };
  std::string frame_id;
  std::vector<Pose> poses;
  std::vector<Marker> markers;
};

struct Color {
  double r = 0;
  double g = 0;
  double b = 0;
  double a = 0;
};

struct KeyValuePair {
  std::string key;
  std::string value;
};

struct PointsAnnotation {
  enum class Type : std::uint8_t { points = 1, line_loop, line_strip, line_list };
  HostTime timestamp;
  Type type = Type::points;
  std::vector<Vec2> points;
  Color outline_color;
  double thickness = 0;
  std::vector<KeyValuePair> metadata;
};

struct TextAnnotation {
  HostTime timestamp;
  Vec2 position;
  std::string text;
  double font_size = 0;
  Color text_color;
};

struct ImageAnnotationsMessage {
  std::vector<PointsAnnotation> points;
  std::vector<TextAnnotation> texts;
};

// ---------------------------------------------------------------------------------------------------------------------
// Parts

template <class Io>
void describe(Io& io, typename Io::template Ref<SampleHeader> header) {
  io.uint(1, header.status);
  io.uint(2, header.sequence);
  io.time(3, header.arrival_time);
  io.device_time(4, header.device_time);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<Vec2> vector) {
  io.real(1, vector.x);
  io.real(2, vector.y);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<Vec3> vector) {
  io.real(1, vector.x);
  io.real(2, vector.y);
  io.real(3, vector.z);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<ImageRect> rect) {
  io.real(1, rect.x);
  io.real(2, rect.y);
  io.real(3, rect.width);
  io.real(4, rect.height);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<Covariance2> covariance) {
  io.real(1, covariance.xx);
  io.real(2, covariance.xy);
  io.real(3, covariance.yy);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<Covariance3> covariance) {
  io.real(1, covariance.xx);
  io.real(2, covariance.xy);
  io.real(3, covariance.xz);
  io.real(4, covariance.yy);
  io.real(5, covariance.yz);
  io.real(6, covariance.zz);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<Quaternion> quaternion) {
  io.real(1, quaternion.x);
  io.real(2, quaternion.y);
  io.real(3, quaternion.z);
  io.real(4, quaternion.w);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<Pose> pose) {
  io.message(1, pose.position);
  io.message(2, pose.orientation);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<PosesInFrameMessage::Marker> marker) {
  io.text(1, marker.name);
  io.flag(2, marker.has_covariance);
  io.message(3, marker.covariance_m2);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<Color> color) {
  io.real(1, color.r);
  io.real(2, color.g);
  io.real(3, color.b);
  io.real(4, color.a);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<KeyValuePair> pair) {
  io.text(1, pair.key);
  io.text(2, pair.value);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<PointsAnnotation> annotation) {
  io.time(1, annotation.timestamp);
  io.choice(2, annotation.type, PointsAnnotation::Type::points, PointsAnnotation::Type::line_list);
  io.repeated(3, annotation.points);
  io.message(4, annotation.outline_color);
  io.real(7, annotation.thickness);
  io.repeated(8, annotation.metadata);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<TextAnnotation> annotation) {
  io.time(1, annotation.timestamp);
  io.message(2, annotation.position);
  io.text(3, annotation.text);
  io.real(4, annotation.font_size);
  io.message(5, annotation.text_color);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<Health::Stream> stream) {
  io.text(1, stream.topic);
  io.uint(2, stream.counters.received);
  io.uint(3, stream.counters.recorded);
  io.uint(4, stream.counters.dropped);
  io.uint(5, stream.counters.gaps);
  io.uint(6, stream.counters.bad);
  io.uint(7, stream.counters.late);
  io.real(8, stream.rate_hz);
  io.real(9, stream.age_s);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<Health::Device> device) {
  io.text(1, device.name);
  io.choice(2, device.state, DeviceState::starting, DeviceState::finished);
  io.text(3, device.message);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<Health::Copy> copy) {
  io.text(1, copy.directory);
  io.choice(2, copy.state, DeviceState::starting, DeviceState::finished);
  io.text(3, copy.message);
  io.uint(4, copy.verified_bytes);
  io.uint(5, copy.behind_bytes);
}

// ---------------------------------------------------------------------------------------------------------------------
// Payloads of roseau's own messages: fields 1 and 2 are the sample time and the header

template <class Io>
void describe(Io& io, typename Io::template Ref<RawBytes> raw) {
  io.piece(3, raw.storage, raw.size);
  io.uint(4, raw.line_errors);
  io.duration(5, raw.byte_time);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<OperatorAction> action) {
  io.choice(3, action.kind, OperatorAction::Kind::mark, OperatorAction::Kind::trigger);
  io.text(4, action.text);
  io.text(5, action.camera);
  io.message(6, action.region);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<SkipMessage> skip) {
  io.text(3, skip.topic);
  io.uint(4, skip.sequence);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<WindSample> wind) {
  io.real(3, wind.u_mps);
  io.real(4, wind.v_mps);
  io.real(5, wind.w_mps);
  io.real(6, wind.sonic_temperature_celsius);
  io.real(7, wind.speed_of_sound_mps);
  io.uint(8, wind.device_status);
  io.flag(9, wind.valid);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<Displacement> displacement) {
  io.real(3, displacement.x);
  io.real(4, displacement.y);
  io.message(5, displacement.covariance);
  io.choice(6, displacement.unit, LengthUnit::pixel, LengthUnit::other);
  io.message(7, displacement.region);
  io.uint(8, displacement.features);
  io.real32(9, displacement.health);
  io.flag(10, displacement.valid);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<Identification> identification) {
  io.real(3, identification.natural_frequency_hz);
  io.real(4, identification.natural_frequency_sd_hz);
  io.real(5, identification.damping_ratio);
  io.real(6, identification.damping_ratio_sd);
  io.real(7, identification.noise_sd);
  io.real(8, identification.force_slope);
  io.real(9, identification.peak_to_floor);
  io.message(10, identification.axis);
  io.real(11, identification.window_s);
  io.flag(12, identification.accepted);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<WindEstimate> estimate) {
  io.real(3, estimate.wind_mps);
  io.real(4, estimate.wind_sd_mps);
  io.real(5, estimate.force_per_mass);
  io.real(6, estimate.force_per_mass_sd);
  io.real(7, estimate.lag_s);
  io.flag(8, estimate.accepted);
  io.flag(9, estimate.settling);
  io.flag(10, estimate.scale_known);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<WindCalibration> calibration) {
  io.text(3, calibration.reference);
  io.real(4, calibration.gain);
  io.real(5, calibration.offset);
  io.real(6, calibration.exponent);
  io.real(7, calibration.delay_s);
  io.real(8, calibration.direction_deg);
  io.real(9, calibration.explained);
  io.real(10, calibration.correlation);
  io.real(11, calibration.rms_mps);
  io.real(12, calibration.seconds_used);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<ForceSpectrum> spectrum) {
  io.floats(3, spectrum.frequency_hz);
  io.floats(4, spectrum.displacement_power);
  io.floats(5, spectrum.model_power);
  io.floats(6, spectrum.force_power);
  io.floats(7, spectrum.force_noise_power);
  io.real32(8, spectrum.trust_low_hz);
  io.real32(9, spectrum.trust_high_hz);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<ClockState> clock) {
  io.text(3, clock.device);
  io.real(4, clock.offset_s);
  io.real(5, clock.offset_sd_s);
  io.real(6, clock.frequency_offset_ppm);
  io.real(7, clock.jitter_s);
  io.uint(8, clock.samples);
  io.uint(9, clock.resets);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<LedBoardTime> board) {
  io.choice(3, board.event, LedBoardTime::Event::latch, LedBoardTime::Event::answer_sent);
  io.uint(4, board.tick);
  io.uint(5, board.microseconds);
  io.uint(6, board.sequence);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<ModalState> modes) {
  io.text(3, modes.structure);
  io.doubles(4, modes.natural_frequency_hz);
  io.doubles(5, modes.damping_ratio);
  io.doubles(6, modes.amplitude);
  io.doubles(7, modes.modal_force);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<Gap> gap) {
  io.text(3, gap.topic);
  io.uint(4, gap.missing);
  io.uint(5, gap.expected_sequence);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<Drop> drop) {
  io.text(3, drop.topic);
  io.text(4, drop.stage);
  io.uint(5, drop.count);
}

template <class Io>
void describe(Io& io, typename Io::template Ref<Health> health) {
  io.repeated(3, health.streams);
  io.repeated(4, health.devices);
  io.choice(5, health.recorder, DeviceState::starting, DeviceState::finished);
  io.text(6, health.recorder_message);
  io.text(7, health.recording_path);
  io.real(8, health.recording_s);
  io.uint(9, health.recorded_bytes);
  io.uint(10, health.disk_free_bytes);
  io.choice(11, health.recording_phase, RecordingPhase::idle, RecordingPhase::post_trigger);
  io.text(12, health.recording_cause);
  io.real(13, health.recording_ends_s);
  io.uint(14, health.recording_part);
  io.uint(15, health.session_bytes);
  io.real(16, health.write_rate_bytes_per_s);
  io.real(17, health.disk_free_s);
  io.real(18, health.pre_trigger_s);
  io.uint(19, health.pre_trigger_bytes);
  io.uint(20, health.pre_trigger_cut_off);
  io.message(21, health.copy);
  io.real(22, health.battery_percent);
  io.flag(23, health.on_battery);
}

template <class Message>
concept FoxgloveMessage =
    std::same_as<Message, RawImageMessage> || std::same_as<Message, CompressedImageMessage> ||
    std::same_as<Message, CameraCalibrationMessage> || std::same_as<Message, ImageAnnotationsMessage> ||
    std::same_as<Message, LogEntry> || std::same_as<Message, PoseInFrameMessage> || std::same_as<Message, PosesInFrameMessage>;

/// A whole message of roseau's own.
template <class Io, class Payload>
  requires(!FoxgloveMessage<std::remove_const_t<Payload>>)
void describe_message(Io& io, typename Io::template Ref<SampleHeader> header, Payload& payload) {
  io.time(1, header.sample_time);
  io.message(2, header);
  describe(io, payload);
}

// ---------------------------------------------------------------------------------------------------------------------
// Foxglove's messages, with roseau's header as an additional field

template <class Io>
void describe_message(Io& io, typename Io::template Ref<SampleHeader> header,
                      typename Io::template Ref<RawImageMessage> image) {
  io.time(1, header.sample_time);
  io.fixed32(2, image.width);
  io.fixed32(3, image.height);
  io.text(4, image.encoding);
  io.fixed32(5, image.step);
  io.text(7, image.frame_id);
  io.message(kHeaderField, header);
  io.duration(2001, image.exposure_duration);
  io.last_bytes(6, image.data);
}

template <class Io>
void describe_message(Io& io, typename Io::template Ref<SampleHeader> header,
                      typename Io::template Ref<CompressedImageMessage> image) {
  io.time(1, header.sample_time);
  io.text(3, image.format);
  io.text(4, image.frame_id);
  io.message(kHeaderField, header);
  io.duration(2001, image.exposure_duration);
  io.text(2002, image.encoding);
  io.last_bytes(2, image.data);
}

template <class Io>
void describe_message(Io& io, typename Io::template Ref<SampleHeader> header,
                      typename Io::template Ref<CameraCalibrationMessage> calibration) {
  io.time(1, header.sample_time);
  io.fixed32(2, calibration.width);
  io.fixed32(3, calibration.height);
  io.text(4, calibration.distortion_model);
  io.doubles(5, calibration.d);
  io.doubles(6, calibration.k);
  io.doubles(7, calibration.r);
  io.doubles(8, calibration.p);
  io.text(9, calibration.frame_id);
  io.message(kHeaderField, header);
  io.doubles(2001, calibration.rotation_camera_from_world);
  io.message(2002, calibration.position_in_world_m);
}

template <class Io>
void describe_message(Io& io, typename Io::template Ref<SampleHeader> header,
                      typename Io::template Ref<ImageAnnotationsMessage> annotations) {
  io.repeated(2, annotations.points);
  io.repeated(3, annotations.texts);
  io.time(5, header.sample_time);
  io.message(kHeaderField, header);
}

template <class Io>
void describe_message(Io& io, typename Io::template Ref<SampleHeader> header,
                      typename Io::template Ref<PoseInFrameMessage> message) {
  io.time(1, header.sample_time);
  io.text(2, message.frame_id);
  io.message(3, message.pose);
  io.message(kHeaderField, header);
  io.uint(2001, message.station);
  io.uint(2002, message.device_status);
  io.flag(2003, message.valid);
}

template <class Io>
void describe_message(Io& io, typename Io::template Ref<SampleHeader> header,
                      typename Io::template Ref<PosesInFrameMessage> message) {
  io.time(1, header.sample_time);
  io.text(2, message.frame_id);
  io.repeated(3, message.poses);
  io.message(kHeaderField, header);
  io.repeated(2001, message.markers);
}

template <class Io>
void describe_message(Io& io, typename Io::template Ref<SampleHeader> header, typename Io::template Ref<LogEntry> entry) {
  io.time(1, header.sample_time);
  io.choice(2, entry.level, LogEntry::Level::debug, LogEntry::Level::fatal);
  io.text(3, entry.message);
  io.text(4, entry.name);
  io.message(kHeaderField, header);
}

}  // namespace roseau::schema
