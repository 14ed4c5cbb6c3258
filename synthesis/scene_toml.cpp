#include <fmt/format.h>

#include "core/toml/table.h"
#include "synthesis/scene.h"
#include "synthesis/scene_check.h"

namespace roseau::synthesis {

namespace {

void read(TomlTable& table, std::string_view key, double& value) { value = table.number(key, value); }

void read(TomlTable& table, std::string_view key, Vec3& value) {
  const std::vector<double> numbers = table.numbers(key, 3);
  if (numbers.size() == 3) value = {numbers[0], numbers[1], numbers[2]};
}

template <class Integer>
void read_integer(TomlTable& table, std::string_view key, Integer& value, std::int64_t low, std::int64_t high) {
  const std::int64_t given = table.integer(key, static_cast<std::int64_t>(value));
  if (given < low || given > high) {
    table.complain(key, fmt::format("must be between {} and {}, not {}", low, high, given));
    return;
  }
  value = static_cast<Integer>(given);
}

void read_timing(TomlTable& table, DeviceTiming& timing) {
  read(table, "frequency_offset_ppm", timing.frequency_offset_ppm);
  read(table, "start_offset_s", timing.start_offset_s);
  read(table, "latency_s", timing.latency_s);
  read(table, "jitter_s", timing.jitter_s);
}

void read_wind(TomlTable& table, TurbulentWindOptions& wind) {
  read(table, "mean_speed_mps", wind.mean_speed_mps);
  read(table, "direction_from_deg", wind.direction_from_deg);
  read(table, "turbulence_intensity", wind.turbulence_intensity);
  read(table, "across_sd_ratio", wind.across_sd_ratio);
  read(table, "vertical_sd_ratio", wind.vertical_sd_ratio);
  read(table, "length_scale_m", wind.length_scale_m);
  read(table, "across_length_scale_m", wind.across_length_scale_m);
  read(table, "lateral_decay", wind.lateral_decay);
  read(table, "reference_height_m", wind.reference_height_m);
  read(table, "profile_exponent", wind.profile_exponent);
}

void read_branch(TomlTable& table, BranchScene& branch) {
  read(table, "natural_frequency_hz", branch.natural_frequency_hz);
  read(table, "damping_ratio", branch.damping_ratio);
  read(table, "drag_exponent", branch.drag_exponent);
  read(table, "mean_deflection_m", branch.mean_deflection_m);
  read(table, "root_in_world_m", branch.root_in_world_m);
  read(table, "length_m", branch.length_m);
}

void read_camera(TomlTable& table, CameraScene& camera) {
  read_integer(table, "width_px", camera.width_px, 64, 4096);
  read_integer(table, "height_px", camera.height_px, 64, 4096);
  const auto format = pixel_format_from_string(table.text("format", std::string(to_string(camera.format))));
  if (format) {
    camera.format = *format;
  } else {
    table.complain("format", "must be one of bgr8, rgb8, mono8");
  }
  read(table, "focal_length_px", camera.focal_length_px);
  read(table, "position_in_world_m", camera.position_in_world_m);
  read(table, "look_at_in_world_m", camera.look_at_in_world_m);
  read(table, "rate_hz", camera.rate_hz);
  read(table, "exposure_duration_s", camera.exposure_duration_s);
  read_integer(table, "exposure_taps", camera.exposure_taps, 1, 64);
  read(table, "read_noise_counts", camera.read_noise_counts);
  read(table, "shot_noise_gain", camera.shot_noise_gain);
  read_timing(table, camera.timing);
}

void read_sonic(TomlTable& table, SonicScene& sonic) {
  read(table, "position_in_world_m", sonic.position_in_world_m);
  read(table, "north_offset_deg", sonic.north_offset_deg);
  read(table, "rate_hz", sonic.rate_hz);
  read(table, "baud", sonic.baud);
  read(table, "noise_mps", sonic.noise_mps);
  read(table, "air_temperature_celsius", sonic.air_temperature_celsius);
  read(table, "temperature_noise_celsius", sonic.temperature_noise_celsius);
  read(table, "split_probability", sonic.split_probability);
  read_timing(table, sonic.timing);
}

}  // namespace

Result<Scene> scene_from_toml(std::string_view text, const std::string& source_name) {
  auto root = TomlTable::parse(text, source_name);
  if (!root) return root.error();
  Scene scene;
  read_integer(*root, "seed", scene.seed, 0, std::numeric_limits<std::int64_t>::max());
  TomlTable wind = root->table("wind");
  TomlTable branch = root->table("branch");
  TomlTable sonic = root->table("sonic");
  TomlTable truth = root->table("truth");
  std::vector<TomlTable> cameras = root->tables("camera");
  read_wind(wind, scene.wind);
  read_branch(branch, scene.branch);
  if (!cameras.empty()) scene.cameras.resize(cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) read_camera(cameras[i], scene.cameras[i]);
  read_sonic(sonic, scene.sonic);
  scene.truth.enabled = truth.boolean("enabled", scene.truth.enabled);
  read(truth, "wind_rate_hz", scene.truth.wind_rate_hz);

  find_problems(scene, [&](const SceneProblem& problem) {
    TomlTable& table = problem.section == "wind"                ? wind
                       : problem.section == "branch"            ? branch
                       : problem.section == "sonic"             ? sonic
                       : problem.section == "truth"             ? truth
                       : cameras.empty() || problem.key.empty() ? *root
                                                                : cameras[problem.camera];
    table.complain(problem.key.empty() ? problem.section : problem.key, problem.what);
  });
  if (auto finished = root->finish(); !finished) return finished.error();
  return scene;
}

}  // namespace roseau::synthesis
