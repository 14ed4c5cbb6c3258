#include "daemon/config.h"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "core/toml/table.h"
#include "daemon/text_file.h"
#include "drivers/link/link_spec.h"

namespace roseau::daemon {

namespace {

/// Reads keys and complains about values that make no sense, at their own line.
class Reader {
 public:
  Reader(TomlTable table, std::filesystem::path base) : table_(std::move(table)), base_(std::move(base)) {}

  TomlTable& table() { return table_; }
  Reader inner(std::string_view key) { return {table_.table(key), base_}; }
  std::vector<Reader> list(std::string_view key) {
    std::vector<Reader> readers;
    for (auto& inner : table_.tables(key)) readers.emplace_back(std::move(inner), base_);
    return readers;
  }

  double number(std::string_view key, double fallback, double least, double most) {
    const double value = table_.number(key, fallback);
    if (value < least || value > most) complain_range(key, least, most);
    return value;
  }
  int integer(std::string_view key, int fallback, int least, int most) {
    const auto value = table_.integer(key, fallback);
    if (value < least || value > most) complain_range(key, least, most);
    return static_cast<int>(std::clamp<std::int64_t>(value, least, most));
  }
  std::filesystem::path path(const std::string& text) const {
    const std::filesystem::path path(text);
    return path.empty() || path.is_absolute() ? path : base_ / path;
  }
  /// A device's name: becomes the first part of its topics.
  std::string device_name(std::set<std::string>& taken) {
    std::string name = table_.required_text("name");
    const bool plain = !name.empty() &&
                       std::ranges::all_of(name, [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; });
    if (!plain) table_.complain("name", "must be letters, digits, '_' and '-'");
    if (!taken.insert(name).second) table_.complain("name", "is taken by another device");
    return name;
  }

 private:
  void complain_range(std::string_view key, double least, double most) {
    std::ostringstream text;
    text << "must be from " << least << " to " << most;
    table_.complain(key, text.str());
  }
  TomlTable table_;
  std::filesystem::path base_;
};

ImageStorageConfig read_image_storage(Reader& reader, std::string_view key, const ImageStorageConfig& fallback) {
  ImageStorageConfig images = fallback;
  if (const auto storage = image_storage_from_string(reader.table().text(key, std::string(to_string(fallback.storage))))) {
    images.storage = *storage;
  } else {
    reader.table().complain(key, "must be \"raw\", \"png\" or \"jpeg\"");
  }
  images.jpeg_quality = reader.integer("jpeg_quality", fallback.jpeg_quality, 1, 100);
  return images;
}

CameraConfig read_camera(Reader reader, std::set<std::string>& names, const ImageStorageConfig& images) {
  CameraConfig camera;
  camera.name = reader.device_name(names);
  camera.driver = reader.table().required_text("driver");
  if (camera.driver != "video_file") reader.table().complain("driver", "must be \"video_file\"");
  camera.path = reader.path(reader.table().required_text("path"));
  camera.rate_hz = reader.number("rate_hz", 0, 0, 10000);
  camera.grey = reader.table().boolean("grey", camera.grey);
  camera.images = read_image_storage(reader, "storage", images);
  return camera;
}

std::string read_port(TomlTable& table) {
  std::string port = table.required_text("port");
  if (const auto stream = link::make_byte_stream(port); !stream) table.complain("port", ": " + stream.error().message);
  return port;
}

SonicConfig read_sonic(Reader reader, std::set<std::string>& names) {
  SonicConfig sonic;
  auto& options = sonic.options;
  options.name = reader.device_name(names);
  auto& table = reader.table();
  const auto model = wire::anemometer_model_from_string(table.required_text("model"));
  if (model) {
    options.anemometer.model = *model;
  } else {
    table.complain("model", ": " + model.error().message);
  }
  sonic.port = read_port(table);
  if (const auto axes = wind_axes_from_string(table.text("axes", "gill_spar")); axes) {
    options.anemometer.axes = *axes;
  } else {
    table.complain("axes", ": " + axes.error().message);
  }
  options.anemometer.north_offset_deg = reader.number("north_offset_deg", 0, -360, 360);
  options.anemometer.rate_hz = reader.number("rate_hz", options.anemometer.rate_hz, 0.05, 200);
  options.anemometer.is_averaging = table.boolean("is_averaging", options.anemometer.is_averaging);
  options.anemometer.delay_s = table.optional_number("delay_s");
  const std::string node = table.text("node", "");
  if (node.size() > 1) table.complain("node", "must be one letter");
  options.anemometer.node = node.empty() ? '\0' : node.front();
  return sonic;
}

void read_stations(TomlTable& table, std::vector<int>& stations) {
  if (!table.has("stations")) {
    table.numbers("stations");  // known, and left as it is
    return;
  }
  stations.clear();
  for (const double number : table.numbers("stations")) {
    const int station = static_cast<int>(number);
    const bool is_station = number == station && station >= 1 && station <= wire::kFastrakStations;
    const bool is_new = std::ranges::find(stations, station) == stations.end();
    if (is_station && is_new) stations.push_back(station);
    if (!is_station || !is_new) table.complain("stations", "must be numbers from 1 to 4, each once");
  }
  if (stations.empty()) table.complain("stations", "must name at least one");
}

MagneticTrackerConfig read_magnetic_tracker(Reader reader, std::set<std::string>& names) {
  MagneticTrackerConfig config;
  auto& options = config.options;
  options.name = reader.device_name(names);
  auto& table = reader.table();
  const auto model = wire::magnetic_tracker_model_from_string(table.required_text("model"));
  if (model) {
    options.tracker.model = *model;
  } else {
    table.complain("model", ": " + model.error().message);
  }
  config.port = read_port(table);
  read_stations(table, options.tracker.stations);
  if (auto layout = wire::FastrakLayout::parse(table.text("items", options.tracker.layout.text())); layout) {
    options.tracker.layout = std::move(*layout);
  } else {
    table.complain("items", ": " + layout.error().message);
  }
  options.tracker.is_binary = table.boolean("binary", options.tracker.is_binary);
  const auto unit = wire::fastrak_unit_from_string(table.text("unit", std::string(wire::to_string(options.tracker.unit))));
  if (unit) {
    options.tracker.unit = *unit;
  } else {
    table.complain("unit", ": " + unit.error().message);
  }
  options.tracker.delay_s = reader.number("delay_s", options.tracker.delay_s, 0, 10);
  options.sets_up = table.boolean("sets_up", options.sets_up);
  return config;
}

LedBoardConfig read_led_board(Reader reader, std::set<std::string>& names) {
  LedBoardConfig config;
  config.options.name = reader.device_name(names);
  config.port = read_port(reader.table());
  auto& tick_us = config.options.board.tick_us;
  tick_us = static_cast<std::uint32_t>(reader.integer("tick_us", static_cast<int>(tick_us), 50, 100'000));
  config.options.sets_up = reader.table().boolean("sets_up", config.options.sets_up);
  return config;
}

void read_simulation(Reader reader, Config& config) {
  SimulationConfig simulation;
  simulation.scene = reader.path(reader.table().text("scene", ""));
  if (reader.table().has("seed")) {
    simulation.seed = static_cast<std::uint64_t>(reader.integer("seed", 0, 0, 2'000'000'000));
  }
  config.simulation = simulation;
}

void read_tracking(Reader reader, TrackingConfig& config) {
  auto& options = config.options;
  auto& table = reader.table();
  options.automatic_targets = table.boolean("automatic_targets", options.automatic_targets);
  options.automatic_frames = reader.integer("automatic_frames", options.automatic_frames, 2, 10000);
  options.automatic_most_targets = reader.integer("automatic_most_targets", options.automatic_most_targets, 1, 64);
  options.automatic_least_motion_px = reader.number("automatic_least_motion_px", options.automatic_least_motion_px, 0, 1000);
  options.feature_count = reader.integer("feature_count", options.feature_count, 8, 20000);
  options.background_share = reader.number("background_share", options.background_share, 0, 0.95);
  options.subtract_background = table.boolean("subtract_background", options.subtract_background);
  options.pyramid_levels = reader.integer("pyramid_levels", options.pyramid_levels, 0, 8);
  options.window_px = reader.integer("window_px", options.window_px, 5, 101);
  options.forward_backward_px = reader.number("forward_backward_px", options.forward_backward_px, 0.01, 100);
  options.search_radius_px = reader.number("search_radius_px", options.search_radius_px, 1, 4000);
  std::map<std::string, tracking::TrackerOptions> of_camera;
  for (auto& target : reader.list("target")) {
    TargetConfig described;
    described.camera = target.table().required_text("camera");
    described.name = target.table().required_text("name");
    if (!tracking::is_target_name(described.name)) target.table().complain("name", "must be letters, digits, '-', '_' and '.'");
    const auto region = target.table().numbers("region_px", 4);
    if (region.empty() || region[2] <= 0 || region[3] <= 0) {
      target.table().complain("region_px", "must be [x, y, width, height], width and height above 0");
    } else {
      described.region = {region[0], region[1], region[2], region[3]};
      auto& asked = of_camera[described.camera];
      asked.targets.push_back({described.name, described.region});
      if (const auto valid = tracking::validate(asked); !valid) {
        target.table().complain("region_px", ": " + valid.error().message);
        asked.targets.pop_back();
      }
    }
    config.targets.push_back(std::move(described));
  }
  if (const auto valid = tracking::validate(options); !valid) table.complain("window_px", ": " + valid.error().message);
}

void read_estimation(Reader reader, estimation::EstimationOptions& options) {
  auto& table = reader.table();
  auto& found = options.identification;
  const auto band = table.numbers("band_hz", 2);
  if (band.size() == 2) {
    if (!(band[0] > 0 && band[1] > band[0])) table.complain("band_hz", "must be [low, high] with 0 < low < high");
    found.min_frequency_hz = band[0];
    found.max_frequency_hz = band[1];
  }
  found.force_slope = reader.number("force_slope", found.force_slope, -1, 6);
  found.force_slope_sd = reader.number("force_slope_sd", found.force_slope_sd, 0, 10);
  found.gate = reader.number("gate", found.gate, 0, 1e6);
  options.window_s = reader.number("window_s", options.window_s, 5, 3600);
  options.hop_s = reader.number("hop_s", options.hop_s, 0.5, 3600);
  options.first_window_s = reader.number("first_window_s", options.first_window_s, 2, 3600);
  options.hold_s = reader.number("hold_s", options.hold_s, 0, 86400);
  if (table.has("lag_s")) options.lag_s = reader.number("lag_s", 0.25, 0, 60);
  options.reference_topic = table.text("reference_topic", options.reference_topic);
  if (table.has("image_plane_direction_deg")) {
    options.calibration.direction_deg = reader.number("image_plane_direction_deg", 0, -360, 360);
  }
  options.calibration.max_delay_s = reader.number("max_delay_s", options.calibration.max_delay_s, 0, 60);
  options.calibration.low_pass_hz = reader.number("low_pass_hz", options.calibration.low_pass_hz, 0.001, 10);
  options.calibration_interval_s = reader.number("calibration_interval_s", options.calibration_interval_s, 1, 3600);
  if (table.has("calibration_final_after_s")) {
    options.calibration_final_after_s = reader.number("calibration_final_after_s", 0, 20, 1e6);
  }
  options.uncalibrated_scale = reader.number("uncalibrated_scale", options.uncalibrated_scale, 1e-9, 1e9);
}

recorder::TriggerOptions read_trigger(Reader reader, std::set<std::string>& names) {
  recorder::TriggerOptions trigger;
  auto& table = reader.table();
  trigger.name = table.required_text("name");
  if (!names.insert(trigger.name).second) table.complain("name", "is taken by another trigger");
  trigger.topic = table.required_text("topic");
  if (!trigger.topic.starts_with('/')) table.complain("topic", "must begin with '/': \"/sonic/wind\"");
  if (const auto quantity = recorder::trigger_quantity_from_string(table.required_text("quantity")); quantity) {
    trigger.quantity = *quantity;
  } else {
    table.complain("quantity", ": " + quantity.error().message);
  }
  trigger.above = table.required_number("above");
  if (!(trigger.above >= 0)) table.complain("above", "must be 0 or more");
  trigger.hysteresis = reader.number("hysteresis", trigger.hysteresis, 0, std::max(trigger.above, 0.0));
  trigger.for_at_least = from_seconds(reader.number("for_s", 0, 0, 86400));
  trigger.window = from_seconds(reader.number("window_s", to_seconds(trigger.window), 0.1, 86400));
  trigger.rearm = from_seconds(reader.number("rearm_s", 0, 0, 86400));
  return trigger;
}

void read_recording(Reader reader, RecordingConfig& config) {
  auto& table = reader.table();
  config.directory = reader.path(table.text("directory", config.directory.string()));
  config.at_start = table.boolean("at_start", config.at_start);
  config.memory_mib = reader.number("memory_mib", config.memory_mib, 8, 65536);
  config.pre_trigger_s = reader.number("pre_trigger_s", config.pre_trigger_s, 0, 86400);
  config.pre_trigger_mib = reader.number("pre_trigger_mib", config.pre_trigger_mib, 1, 1 << 20U);
  config.post_trigger_s = reader.number("post_trigger_s", config.post_trigger_s, 0, 86400);
  config.split_mib = reader.number("split_mib", config.split_mib, 0, 1e9);
  if (config.split_mib > 0 && config.split_mib < 16) table.complain("split_mib", "must be 16 or more, or 0: one file");
  config.split_s = reader.number("split_s", config.split_s, 0, 1e7);
  if (config.split_s > 0 && config.split_s < 1) table.complain("split_s", "must be 1 or more, or 0: one file");
  config.least_free_mib = reader.number("least_free_mib", config.least_free_mib, 0, 1e9);
  const std::string when_full = table.text("when_full", "stop");
  if (when_full == "oldest") {
    config.when_full = recorder::WhenFull::oldest;
    if (config.split_mib == 0 && config.split_s == 0) {
      table.complain("when_full", "\"oldest\" needs split_mib or split_s: only finished parts are deleted");
    }
  } else if (when_full != "stop") {
    table.complain("when_full", "must be \"stop\" or \"oldest\"");
  }
  config.keep_at_most_gib = reader.number("keep_at_most_gib", config.keep_at_most_gib, 0, 1e6);
  if (config.keep_at_most_gib > 0 && config.when_full != recorder::WhenFull::oldest) {
    table.complain("keep_at_most_gib", "needs when_full = \"oldest\": otherwise nothing is deleted");
  }
  config.copy_directory = reader.path(table.text("copy_directory", ""));
  config.battery_stop_percent = reader.number("battery_stop_percent", config.battery_stop_percent, 0, 95);
  config.resume_after_crash = table.boolean("resume_after_crash", config.resume_after_crash);
  std::set<std::string> names;
  for (auto& trigger : reader.list("trigger")) config.triggers.push_back(read_trigger(std::move(trigger), names));
}

/// Everything but the site sheet.
Config read_config(Reader reader) {
  TomlTable* root = &reader.table();
  Config config;
  config.name = root->text("name", config.name);
  auto recording = reader.inner("recording");
  config.recording.images = read_image_storage(recording, "image_storage", config.recording.images);
  std::set<std::string> names;
  for (auto& camera : reader.list("camera")) {
    config.cameras.push_back(read_camera(std::move(camera), names, config.recording.images));
  }
  for (auto& sonic : reader.list("sonic")) config.sonics.push_back(read_sonic(std::move(sonic), names));
  for (auto& tracker : reader.list("magnetic_tracker")) {
    config.magnetic_trackers.push_back(read_magnetic_tracker(std::move(tracker), names));
  }
  for (auto& board : reader.list("led_board")) config.led_boards.push_back(read_led_board(std::move(board), names));
  if (root->has("simulation")) {
    if (!names.empty()) root->complain("simulation", "replaces devices: leave out [[camera]], [[sonic]] and the others");
    read_simulation(reader.inner("simulation"), config);
  }
  auto sync = reader.inner("sync");
  config.window = from_seconds(sync.number("window_ms", to_seconds(config.window) * 1e3, 0, 10000) * 1e-3);
  config.skip_after_frames =
      static_cast<std::size_t>(sync.integer("skip_after_frames", static_cast<int>(config.skip_after_frames), 1, 64));
  read_tracking(reader.inner("tracking"), config.tracking);
  read_estimation(reader.inner("estimation"), config.estimation);
  read_recording(recording, config.recording);
  auto display = reader.inner("display");
  config.display.address = display.table().text("address", config.display.address);
  config.display.port = static_cast<std::uint16_t>(display.integer("port", config.display.port, 0, 65535));
  return config;
}

}  // namespace

Result<Config> parse_config(const std::string& text, const std::string& source_name,
                            const std::filesystem::path& base_directory, std::vector<std::string>* absent) {
  auto root = TomlTable::parse(text, source_name);
  if (!root) return root.error();
  Reader reader(*root, base_directory);
  const auto site = reader.path(root->text("site", ""));
  Config config = read_config(reader);
  if (auto finished = root->finish(); !finished) return finished.error();
  if (absent != nullptr) *absent = root->absent();
  config.text = text;
  if (site.empty()) return config;
  auto sheet = read_text_file(site);
  if (!sheet) return sheet.error().with_context(root->place("site") + ": site sheet");
  if (auto parsed = TomlTable::parse(*sheet, site.string()); !parsed) return parsed.error();
  config.site_text = std::move(*sheet);
  return config;
}

Result<Config> parse_recorded_config(const std::string& text, const std::string& source_name) {
  auto root = TomlTable::parse(text, source_name);
  if (!root) return root.error();
  root->text("site", "");
  Config config = read_config({*root, ""});
  if (auto finished = root->finish(); !finished) return finished.error();
  config.text = text;
  return config;
}

Result<Config> load_config(const std::filesystem::path& path) {
  auto text = read_text_file(path);
  if (!text) return text.error();
  return parse_config(*text, path.string(), path.parent_path());
}

}  // namespace roseau::daemon
