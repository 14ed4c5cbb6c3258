// Config: what a session is made of, from TOML. Every key, with its unit, is documented in config/reference.toml, which the
// tests read: what is there is what is known.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/frame.h"
#include "core/geometry.h"
#include "core/result.h"
#include "core/time.h"
#include "drivers/led_sync/led_board_source.h"
#include "drivers/magnetic_tracker/magnetic_tracker_source.h"
#include "drivers/sonic/sonic_source.h"
#include "estimation/options.h"
#include "recorder/control/disk_guard.h"
#include "recorder/control/trigger.h"
#include "tracking/options.h"

namespace roseau::daemon {

/// How a camera's pictures are recorded.
struct ImageStorageConfig {
  ImageStorage storage = ImageStorage::raw;
  int jpeg_quality = 90;
};

struct CameraConfig {
  std::string name;
  std::string driver;          // "video_file"
  std::filesystem::path path;  // video_file
  double rate_hz = 0;          // video_file: overrides what the file says; 0 = as the file says
  bool grey = false;           // video_file: mono8 instead of bgr8
  ImageStorageConfig images;   // what it leaves out is as in [recording]
};

struct SonicConfig {
  sonic::SonicOptions options;
  std::string port;  // link specification: "serial:/dev/ttyUSB0?baud=19200"
};

struct MagneticTrackerConfig {
  magnetic_tracker::MagneticTrackerOptions options;
  std::string port;  // link specification
};

struct LedBoardConfig {
  led_sync::LedBoardOptions options;
  std::string port;  // link specification
};

struct SimulationConfig {
  std::filesystem::path scene;  // empty: the built-in demo scene
  std::optional<std::uint64_t> seed;
};

struct RecordingConfig {
  std::filesystem::path directory = "recordings";
  bool at_start = false;
  double memory_mib = 256;    // between the pipeline and the disk
  ImageStorageConfig images;  // of all cameras that say nothing else, the simulated rig's included

  double pre_trigger_s = 0;  // of the past that a recording begins with
  double pre_trigger_mib = 1024;
  double post_trigger_s = 10;
  std::vector<recorder::TriggerOptions> triggers;

  double split_mib = 0;  // 0: one file
  double split_s = 0;
  double least_free_mib = 1024;
  recorder::WhenFull when_full = recorder::WhenFull::stop;
  double keep_at_most_gib = 0;           // 0: as many as fit
  std::filesystem::path copy_directory;  // empty: no copy
  double battery_stop_percent = 0;       // 0: the battery is no matter
  bool resume_after_crash = false;
};

struct DisplayConfig {
  std::string address = "127.0.0.1";
  std::uint16_t port = 8420;
};

/// A target known before the first frame.
struct TargetConfig {
  std::string camera;
  std::string name;
  ImageRect region;
};

struct TrackingConfig {
  tracking::TrackerOptions options;
  std::vector<TargetConfig> targets;
};

struct Config {
  std::string name = "session";
  std::string text;       // as read: travels in every session
  std::string site_text;  // the site sheet, TOML; empty when there is none
  std::vector<CameraConfig> cameras;
  std::vector<SonicConfig> sonics;
  std::vector<MagneticTrackerConfig> magnetic_trackers;
  std::vector<LedBoardConfig> led_boards;
  std::optional<SimulationConfig> simulation;
  Duration window = std::chrono::milliseconds(40);
  std::size_t skip_after_frames = 15;
  TrackingConfig tracking;
  estimation::EstimationOptions estimation;
  RecordingConfig recording;
  DisplayConfig display;
};

/// `source_name` is for messages; relative paths in the text are taken from `base_directory`. Reads the site sheet and checks
/// that it is TOML. Errors name the file, the line and the key.
/// `absent`, when given, receives the keys that are known and left out (config/reference.toml must leave out none).
Result<Config> parse_config(const std::string& text, const std::string& source_name,
                            const std::filesystem::path& base_directory, std::vector<std::string>* absent = nullptr);
Result<Config> load_config(const std::filesystem::path& path);

/// A configuration that travelled in a session: what it names on disk belongs to another machine and is left alone.
Result<Config> parse_recorded_config(const std::string& text, const std::string& source_name);

}  // namespace roseau::daemon
