#include "synthesis/scene_check.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <optional>

namespace roseau::synthesis {

namespace {

using Report = std::function<void(const SceneProblem&)>;

class Section {
 public:
  Section(std::string_view name, std::size_t camera, const Report& report) : name_(name), camera_(camera), report_(report) {}

  void require(bool holds, std::string_view key, std::string what) const {
    if (!holds) report_({name_, camera_, key, std::move(what)});
  }
  void require_positive(double value, std::string_view key) const {
    require(std::isfinite(value) && value > 0, key, fmt::format("must be above 0, not {}", value));
  }
  void require_not_negative(double value, std::string_view key) const {
    require(std::isfinite(value) && value >= 0, key, fmt::format("must not be below 0, not {}", value));
  }
  void require_between(double value, double low, double high, std::string_view key) const {
    require(value >= low && value <= high, key, fmt::format("must be between {} and {}, not {}", low, high, value));
  }
  void check_timing(const DeviceTiming& timing) const {
    require_between(timing.frequency_offset_ppm, -10000, 10000, "frequency_offset_ppm");
    require_not_negative(timing.start_offset_s, "start_offset_s");
    require_between(timing.latency_s, 0, 10, "latency_s");
    require_between(timing.jitter_s, 0, 1, "jitter_s");
  }

 private:
  std::string_view name_;
  std::size_t camera_;
  const Report& report_;
};

void check_wind(const TurbulentWindOptions& wind, const Section& section) {
  section.require_between(wind.mean_speed_mps, 0.1, 60, "mean_speed_mps");
  section.require_between(wind.direction_from_deg, -360, 360, "direction_from_deg");
  section.require_between(wind.turbulence_intensity, 0, 1, "turbulence_intensity");
  section.require_not_negative(wind.across_sd_ratio, "across_sd_ratio");
  section.require_not_negative(wind.vertical_sd_ratio, "vertical_sd_ratio");
  section.require_positive(wind.length_scale_m, "length_scale_m");
  section.require_positive(wind.across_length_scale_m, "across_length_scale_m");
  section.require_not_negative(wind.lateral_decay, "lateral_decay");
  section.require_positive(wind.reference_height_m, "reference_height_m");
  section.require_between(wind.profile_exponent, 0, 1, "profile_exponent");
}

void check_branch(const BranchScene& branch, const Section& section) {
  section.require_between(branch.natural_frequency_hz, 0.05, 20, "natural_frequency_hz");
  section.require_between(branch.damping_ratio, 0.001, 0.9, "damping_ratio");
  section.require_between(branch.drag_exponent, 1, 3, "drag_exponent");
  section.require_between(branch.mean_deflection_m, 0, 0.5, "mean_deflection_m");
  section.require_between(branch.length_m, 0.5, 5, "length_m");
}

void check_camera(const CameraScene& camera, const BranchScene& branch, const Section& section) {
  section.require_between(camera.width_px, 64, 4096, "width_px");
  section.require_between(camera.height_px, 64, 4096, "height_px");
  section.require(camera.format != PixelFormat::mono16, "format", "must be one of bgr8, rgb8, mono8");
  section.require_between(camera.focal_length_px, 50, 20000, "focal_length_px");
  section.require_between(camera.rate_hz, 0.1, 1000, "rate_hz");
  section.require(camera.exposure_duration_s >= 0 && camera.exposure_duration_s * camera.rate_hz <= 1, "exposure_duration_s",
                  "must not be below 0 nor longer than the time between two frames");
  section.require_between(camera.exposure_taps, 1, 64, "exposure_taps");
  section.require_between(camera.read_noise_counts, 0, 100, "read_noise_counts");
  section.require_between(camera.shot_noise_gain, 0, 10, "shot_noise_gain");
  const Vec3& from = camera.position_in_world_m;
  const Vec3& to = camera.look_at_in_world_m;
  section.require(from.y < branch.root_in_world_m.y - 1, "position_in_world_m", "must be at least 1 m south of the branch");
  section.require(from.y >= branch.root_in_world_m.y - 1 || to.y - from.y > std::hypot(to.x - from.x, to.z - from.z),
                  "look_at_in_world_m", "must be to the north of the camera, within 45 degrees");
  section.check_timing(camera.timing);
}

void check_sonic(const SonicScene& sonic, const Section& section) {
  constexpr std::array kRates{1.0, 2.0, 4.0, 5.0, 8.0, 10.0, 16.0, 20.0, 32.0};
  bool is_known_rate = false;
  for (const double rate : kRates) is_known_rate = is_known_rate || rate == sonic.rate_hz;
  section.require(is_known_rate, "rate_hz", "must be one of a WindMaster's: 1, 2, 4, 5, 8, 10, 16, 20, 32");
  constexpr double kBitsPerRecord = 530;  // 53 bytes of 10 bits
  section.require(sonic.baud >= kBitsPerRecord * sonic.rate_hz, "baud",
                  fmt::format("must be at least {} for {} records a second", kBitsPerRecord * sonic.rate_hz, sonic.rate_hz));
  section.require_between(sonic.north_offset_deg, -360, 360, "north_offset_deg");
  section.require_between(sonic.noise_mps, 0, 10, "noise_mps");
  section.require_between(sonic.air_temperature_celsius, -60, 60, "air_temperature_celsius");
  section.require_between(sonic.temperature_noise_celsius, 0, 10, "temperature_noise_celsius");
  section.require_between(sonic.split_probability, 0, 1, "split_probability");
  section.check_timing(sonic.timing);
}

}  // namespace

void find_problems(const Scene& scene, const Report& report) {
  check_wind(scene.wind, {"wind", 0, report});
  check_branch(scene.branch, {"branch", 0, report});
  Section("camera", 0, report).require(!scene.cameras.empty() && scene.cameras.size() <= 8, "", "must be given 1 to 8 times");
  for (std::size_t i = 0; i < scene.cameras.size(); ++i) check_camera(scene.cameras[i], scene.branch, {"camera", i, report});
  check_sonic(scene.sonic, {"sonic", 0, report});
  Section("truth", 0, report).require_between(scene.truth.wind_rate_hz, 0.1, 1000, "wind_rate_hz");
}

Result<void> check(const Scene& scene) {
  std::optional<Error> first;
  find_problems(scene, [&first](const SceneProblem& problem) {
    if (first) return;
    const std::string section =
        problem.section == "camera" ? fmt::format("camera {}", problem.camera) : std::string(problem.section);
    first = Error{ErrorCode::invalid_argument, fmt::format("scene: {}: {} {}", section, problem.key, problem.what)};
  });
  if (first) return *first;
  return {};
}

}  // namespace roseau::synthesis
