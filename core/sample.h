// Samples: one header for all, one payload type per kind of measurement or result. Each type is defined here, once;
// schema/ holds its only conversion to and from the recorded messages.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "core/frame.h"
#include "core/geometry.h"
#include "core/stream.h"
#include "core/time.h"

namespace roseau {

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

// ---------------------------------------------------------------------------------------------------------------------
// Inputs

/// Bytes of a byte-stream device exactly as read: a piece of the stream, not a record. Held inline, so that device threads
/// allocate nothing; a longer read is split. The header's arrival time is that of the FIRST byte.
struct RawBytes {
  static constexpr std::size_t kCapacity = 224;

  std::array<std::byte, kCapacity> storage{};
  std::uint16_t size = 0;
  std::uint16_t line_errors = 0;  // parity, framing and break errors the port reported with these bytes
  Duration byte_time{0};          // time one byte takes on the wire; 0 where it is unknown or no matter (TCP)

  std::span<const std::byte> bytes() const { return std::span(storage).first(size); }
};

/// Pinhole with Brown-Conrady distortion (Foxglove's "plumb_bob": k1 k2 p1 p2 k3). fx == 0 means uncalibrated.
struct CameraCalibration {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  double fx_px = 0;
  double fy_px = 0;
  double cx_px = 0;
  double cy_px = 0;
  std::array<double, 5> distortion{};
  std::array<double, 9> rotation_camera_from_world{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major
  Vec3 position_in_world_m;
};

/// What the operator did, or a program for him. An input like any other: recorded, and obeyed again on replay.
struct OperatorAction {
  enum class Kind : std::uint8_t {
    mark,
    add_target,
    remove_target,
    start_recording,
    stop_recording,
    note,
    trigger,  // something happens now: record what came before and what comes after, as configured
  };
  Kind kind = Kind::mark;
  std::string text;    // mark, note or trigger: what for; target name for add_target and remove_target
  std::string camera;  // add_target: device name of the camera ("camera0")
  ImageRect region;    // add_target: where, in that camera's pixels
};

/// The sequencer decided that this input sample is not analysed because tracking was behind (live only).
/// An input: replay skips the same samples.
struct Skip {
  StreamId stream = 0;
  std::uint32_t sequence = 0;
};

// ---------------------------------------------------------------------------------------------------------------------
// Measurements

/// One record of an anemometer, in the instrument's own axes (stream metadata "axes", "north_offset_deg").
/// Values not measured, or flagged by the instrument, are NaN.
struct WindSample {
  double u_mps = kNotMeasured;
  double v_mps = kNotMeasured;
  double w_mps = kNotMeasured;
  double sonic_temperature_celsius = kNotMeasured;
  double speed_of_sound_mps = kNotMeasured;
  std::uint16_t device_status = 0;  // the instrument's code, as sent
  bool valid = true;                // wind usable; false also when the device's status says so
};

/// One record of a magnetic tracker: where one of its stations (receivers) is, in the axes of its source (transmitter).
/// Values that the record does not hold are NaN.
struct StationPose {
  std::uint8_t station = 1;  // the tracker's own number, from 1
  Vec3 position_in_source_m{kNotMeasured, kNotMeasured, kNotMeasured};
  Quaternion source_from_station{kNotMeasured, kNotMeasured, kNotMeasured,
                                 kNotMeasured};  // takes the sensor's axes to the source's
  std::uint16_t device_status = 0;               // the tracker's error code as sent (a letter); 0 = none
  bool valid = true;                             // position usable; false when the tracker reports an error
};

/// An LED board's clock at one event: its counter of ticks, and the time since the last tick. The header's device time is
/// the same in nanoseconds, unwrapped; its sequence is the number below (edges: counted).
struct LedBoardTime {
  enum class Event : std::uint8_t {
    latch,              // the LEDs took on this tick's pattern; sent unasked, every so many ticks
    rising_edge,        // on the board's input
    falling_edge,       //
    question_received,  // of ours, `sequence` being the question's
    answer_sent,
  };
  Event event = Event::latch;
  std::uint32_t tick = 0;          // as sent: wraps
  std::uint32_t microseconds = 0;  // since that tick
  std::uint32_t sequence = 0;      // message number as sent; 0 for edges
};

enum class LengthUnit : std::uint8_t { pixel, metre, strain, other };
std::string_view to_string(LengthUnit unit);

/// Motion of one target relative to its reference position: tracked in a picture, or imported.
struct Displacement {
  double x = 0;  // pictures: to the right
  double y = 0;  // pictures: down; 0 for a one-axis series
  Covariance2 covariance;
  LengthUnit unit = LengthUnit::pixel;
  ImageRect region;            // where the target is now, px; empty for imported series
  std::uint16_t features = 0;  // points that agreed on the motion
  float health = 1;            // 0 lost .. 1 all points agree
  bool valid = true;           // false: lost or occluded, x and y are the last good values
};

/// The points behind a camera's displacements, for showing: where they are and how they moved since the frame before.
struct ImageMotion {
  struct Point {
    float x = 0;  // px, now
    float y = 0;
    float dx = 0;  // px since the previous frame
    float dy = 0;
    std::uint8_t target = 0;  // index into targets; kBackground for static background points
    bool good = true;         // agreed with its target's motion
  };
  static constexpr std::uint8_t kBackground = 255;
  struct Target {
    std::string name;
    ImageRect region;
    float health = 1;
    bool valid = true;
  };
  std::vector<Point> points;
  std::vector<Target> targets;
};

/// Named points in space at one time: markers on a plant or a rig, as reconstructed from pictures or as a simulation knows
/// them. A point that is not seen has NaN coordinates.
struct MarkerPositions {
  struct Marker {
    std::string name;
    Vec3 position_m;
    std::optional<Covariance3> covariance_m2;
  };
  std::string frame = "world";  // whose axes: "world", or a device's name
  std::vector<Marker> markers;
};

// ---------------------------------------------------------------------------------------------------------------------
// Estimates

/// A target seen as one damped oscillator (reference: VIDA thesis chapter 4; docs/estimation.md).
struct Identification {
  double natural_frequency_hz = kNotMeasured;  // undamped, w0 / 2 pi
  double natural_frequency_sd_hz = kNotMeasured;
  double damping_ratio = kNotMeasured;  // gamma / (2 w0)
  double damping_ratio_sd = kNotMeasured;
  double noise_sd = kNotMeasured;       // of one displacement sample, in the displacement's unit
  double force_slope = kNotMeasured;    // p in S_force ~ w^-p
  double peak_to_floor = kNotMeasured;  // resonance peak over the white floor, power ratio: the gate's quantity
  Vec2 axis;                            // unit vector of the main motion in (x, y)
  double window_s = 0;                  // how much data it rests on
  bool accepted = false;                // the gate's answer
};

/// Wind driving one target at one time, in the plane of the picture along the target's main axis.
struct WindEstimate {
  double wind_mps = kNotMeasured;  // signed along the axis; up to a stated scale while scale_known is false
  double wind_sd_mps = kNotMeasured;
  double force_per_mass = kNotMeasured;  // displacement unit / s^2
  double force_per_mass_sd = kNotMeasured;
  double lag_s = 0;          // how long after the sample time it was known: the smoother's fixed lag
  bool accepted = false;     // identification passed its gate
  bool settling = true;      // accepted, but its floor (spread expected from so short a record) is not small yet
  bool scale_known = false;  // calibrated against a reference, so that m/s means m/s
};

/// What wind_mps is made from force with, and how well it explains the reference so far.
struct WindCalibration {
  std::string reference;                // topic of the reference wind
  double gain = kNotMeasured;           // a in V|V|^(n-1) = a f + b
  double offset = kNotMeasured;         // b
  double exponent = kNotMeasured;       // n
  double delay_s = kNotMeasured;        // reference later than estimate: positive
  double direction_deg = kNotMeasured;  // horizontal direction (from) whose wind component is compared
  double explained = kNotMeasured;      // 1 - MSE / Var over data it was not fitted on; NaN until there is enough
  double correlation = kNotMeasured;
  double rms_mps = kNotMeasured;
  double seconds_used = 0;
};

/// A structure as the sum of its vibration modes, mass-normalised: x'' + 2 damping w x' + w^2 x = force, one row per mode.
/// All vectors have one length, except those that are not known and empty.
struct ModalState {
  std::string structure;                     // which: "tree"
  std::vector<double> natural_frequency_hz;  // undamped, w / 2 pi
  std::vector<double> damping_ratio;
  std::vector<double> amplitude;    // x: m sqrt(kg)
  std::vector<double> modal_force;  // m sqrt(kg) / s^2
};

/// Power spectra of a target, one-sided, on a common frequency axis, with the band in which the force can be trusted
/// (VIDA thesis 5.4: where the signal is above white tracking noise).
struct ForceSpectrum {
  std::vector<float> frequency_hz;
  std::vector<float> displacement_power;  // unit^2 / Hz
  std::vector<float> model_power;         // fitted oscillator under its force, same unit
  std::vector<float> force_power;         // (unit / s^2)^2 / Hz
  std::vector<float> force_noise_power;   // expected from white displacement noise, same unit
  float trust_low_hz = 0;
  float trust_high_hz = 0;
};

// ---------------------------------------------------------------------------------------------------------------------
// About the system

struct ClockState {
  std::string device;
  double offset_s = 0;  // host = device + offset at the sample's time
  double offset_sd_s = 0;
  double frequency_offset_ppm = 0;  // device fast: positive
  double jitter_s = 0;              // spread of arrival residuals
  std::uint64_t samples = 0;
  std::uint32_t resets = 0;
};

/// Hole in a device's own numbering: samples that never reached us.
struct Gap {
  std::string topic;
  std::uint32_t missing = 0;
  std::uint32_t expected_sequence = 0;
};

/// Items we threw away, where and how many since the last report.
struct Drop {
  std::string topic;
  std::string stage;  // "image_coding", "sequencer", "recorder", "tracking", "display"
  std::uint64_t count = 0;
};

enum class DeviceState : std::uint8_t { starting, running, degraded, reopening, failed, finished };
std::string_view to_string(DeviceState state);

/// What recording is doing. Idle: the newest samples are kept for a trigger to come, if configured.
enum class RecordingPhase : std::uint8_t { idle, recording, post_trigger };
std::string_view to_string(RecordingPhase phase);

/// Counters of one stream since the session began (in a file: of that file alone).
struct StreamCounters {
  std::uint64_t received = 0;
  std::uint64_t recorded = 0;
  std::uint64_t dropped = 0;
  std::uint64_t gaps = 0;
  std::uint64_t bad = 0;
  std::uint64_t late = 0;

  // Where what was dropped was dropped. Their sum is `dropped`, but for frames that were recorded and not analysed (Skip).
  std::uint64_t dropped_intake = 0;   // between device and sequencer: its ring was full
  std::uint64_t dropped_queue = 0;    // the recorder's queue was full: the disk was too slow
  std::uint64_t dropped_encoder = 0;  // pictures: the encoder failed
  std::uint64_t dropped_write = 0;    // a write failed, or came after one that had failed

  std::uint64_t repeated = 0;  // of `recorded`: copies of what an earlier part of the session holds
};

/// Once a second: how everything is. Never part of the digest.
struct Health {
  struct Stream {
    std::string topic;
    StreamCounters counters;
    double rate_hz = 0;
    double age_s = 0;  // since its last sample
  };
  struct Device {
    std::string name;
    DeviceState state = DeviceState::starting;
    std::string message;  // what is wrong and what to do; empty when all is well
  };
  /// The copy that is kept on a second disk while recording.
  struct Copy {
    std::string directory;  // empty: none is wanted
    DeviceState state = DeviceState::starting;
    std::string message;               // what is wrong and what to do
    std::uint64_t verified_bytes = 0;  // read back from the second disk and found right, since the daemon began
    std::uint64_t behind_bytes = 0;    // recorded and not yet verified there
  };
  std::vector<Stream> streams;
  std::vector<Device> devices;
  DeviceState recorder = DeviceState::starting;
  std::string recorder_message;
  std::string recording_path;  // empty: not recording
  double recording_s = 0;
  std::uint64_t recorded_bytes = 0;  // in the present file
  std::uint64_t disk_free_bytes = 0;

  RecordingPhase recording_phase = RecordingPhase::idle;
  std::string recording_cause;            // who or what started it: "operator", "at start", "trigger gust"; empty when idle
  double recording_ends_s = 0;            // post-trigger: recording ends this much later, unless triggered again; 0: not set
  std::uint32_t recording_part = 0;       // number of the present file among those of its session, from 1; 0: none
  std::uint64_t session_bytes = 0;        // in all parts of this session so far
  double write_rate_bytes_per_s = 0;      // smoothed
  double disk_free_s = 0;                 // at this rate, until the least free space is reached; 0: not known
  double pre_trigger_s = 0;               // what a trigger now would get of the past, log time
  std::uint64_t pre_trigger_bytes = 0;    // it takes this much memory
  std::uint64_t pre_trigger_cut_off = 0;  // samples that were young enough to be kept and had no room, since the daemon began
  Copy copy;
  double battery_percent = 0;  // 0: there is none, or it does not say
  bool on_battery = false;
};

struct LogEntry {
  enum class Level : std::uint8_t { debug = 1, info, warning, error, fatal };  // Foxglove's numbers
  Level level = Level::info;
  std::string name;  // device or folder it concerns
  std::string message;
};

// ---------------------------------------------------------------------------------------------------------------------

using Payload = std::variant<RawBytes, Frame, CameraCalibration, OperatorAction, Skip, WindSample, Displacement, ImageMotion,
                             Identification, WindEstimate, WindCalibration, ForceSpectrum, ClockState, Gap, Drop, Health,
                             LogEntry, StationPose, LedBoardTime, MarkerPositions, ModalState>;

/// Index into Payload, in the same order.
enum class SampleKind : std::uint8_t {
  raw_bytes,
  frame,
  camera_calibration,
  operator_action,
  skip,
  wind,
  displacement,
  image_motion,
  identification,
  wind_estimate,
  wind_calibration,
  force_spectrum,
  clock_state,
  gap,
  drop,
  health,
  log,
  station_pose,
  led_board_time,
  marker_positions,
  modal_state,
};
inline constexpr std::size_t kSampleKindCount = std::variant_size_v<Payload>;

std::string_view to_string(SampleKind kind);
std::optional<SampleKind> sample_kind_from_string(std::string_view name);

/// Bits; 0 = ok. A bad sample is a value with a status, never an error.
enum SampleStatus : std::uint16_t {
  kStatusOk = 0,
  kStatusLate = 1 << 0,       // came after its window had closed: passed on out of order
  kStatusDuplicate = 1 << 1,  // same sequence again
  kStatusBadChecksum = 1 << 2,
  kStatusMalformed = 1 << 3,
  kStatusDeviceError = 1 << 4,  // the device itself says that the value is bad
  kStatusIncomplete = 1 << 5,   // part of the frame or record is missing
};

struct SampleHeader {
  StreamId stream = 0;
  std::uint16_t status = kStatusOk;
  std::uint32_t sequence = 0;             // device's own number where it has one, else counted per stream
  HostTime arrival_time;                  // first byte or frame completion at the host
  HostTime sample_time;                   // when it was true in the world (exposure midpoint, centre of averaging)
  std::optional<DeviceTime> device_time;  // the device's own stamp, unwrapped
};

struct Sample {
  SampleHeader header;
  Payload payload;

  SampleKind kind() const { return static_cast<SampleKind>(payload.index()); }
};

}  // namespace roseau
