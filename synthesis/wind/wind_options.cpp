#include "synthesis/wind/wind_options.h"

#include <fmt/format.h>

#include <cmath>

#include "synthesis/wind/sum_of_winds.h"

namespace roseau::synthesis {

namespace {

using Report = std::function<void(const WindProblem&)>;

class Section {
 public:
  Section(std::string_view name, std::size_t index, const Report& report) : name_(name), index_(index), report_(report) {}

  void require(bool holds, std::string_view key, std::string what) const {
    if (!holds) report_({name_, index_, key, std::move(what)});
  }
  void require_between(double value, double low, double high, std::string_view key) const {
    require(value >= low && value <= high, key, fmt::format("must be between {} and {}, not {}", low, high, value));
  }

 private:
  std::string_view name_;
  std::size_t index_;
  const Report& report_;
};

constexpr double kFarM = 1e5;

void check_place(const Vec3& place, std::string_view key, const Section& section) {
  for (const double coordinate : {place.x, place.y, place.z}) section.require_between(coordinate, -kFarM, kFarM, key);
}

void check_profile(ProfileShape shape, double exponent, double roughness_m, double displacement_m, double reference_m,
                   std::string_view reference_key, const Section& section) {
  section.require_between(exponent, 0, 1, "profile_exponent");
  section.require_between(roughness_m, 1e-5, 10, "roughness_length_m");
  section.require_between(displacement_m, 0, 100, "displacement_height_m");
  section.require(
      shape != ProfileShape::logarithmic || reference_m > displacement_m + roughness_m, reference_key,
      fmt::format("must be above displacement_height_m + roughness_length_m = {} m with a logarithmic profile, not {}",
                  displacement_m + roughness_m, reference_m));
}

void check_turbulence(const TurbulentWindOptions& wind, const Section& section) {
  section.require(wind.mean_speed_mps == 0 || (wind.mean_speed_mps >= 0.1 && wind.mean_speed_mps <= 60), "mean_speed_mps",
                  fmt::format("must be 0 (calm) or between 0.1 and 60, not {}", wind.mean_speed_mps));
  section.require_between(wind.direction_from_deg, -360, 360, "direction_from_deg");
  section.require_between(wind.turbulence_intensity, 0, 1, "turbulence_intensity");
  section.require_between(wind.across_sd_ratio, 0, 10, "across_sd_ratio");
  section.require_between(wind.vertical_sd_ratio, 0, 10, "vertical_sd_ratio");
  section.require_between(wind.length_scale_m, 0.1, 10000, "length_scale_m");
  section.require_between(wind.across_length_scale_m, 0.1, 10000, "across_length_scale_m");
  section.require_between(wind.vertical_length_scale_m, 0.1, 10000, "vertical_length_scale_m");
  section.require_between(wind.lateral_decay, 0.01, 1000, "lateral_decay");
  section.require_between(wind.vertical_decay, 0.01, 1000, "vertical_decay");
  section.require_between(wind.reference_height_m, 0.1, 1000, "reference_height_m");
  section.require_between(wind.strand_spacing_m, 0.01, 1000, "strand_spacing_m");
  section.require_between(wind.period_s, 60, 86400, "period_s");
  check_profile(wind.profile, wind.profile_exponent, wind.roughness_length_m, wind.displacement_height_m,
                wind.reference_height_m, "reference_height_m", section);
}

void check_recording(const RecordedWindOptions& recording, const Section& section) {
  section.require_between(recording.rate_hz, 0.1, 1000, "rate_hz");
  section.require_between(recording.start_s, 0, 1e9, "start_s");
  check_place(recording.place_in_world_m, "place_in_world_m", section);
  section.require_between(recording.place_in_world_m.z, 0.1, 1000, "place_in_world_m");
  check_profile(recording.profile, recording.profile_exponent, recording.roughness_length_m, recording.displacement_height_m,
                recording.place_in_world_m.z, "place_in_world_m", section);
}

void check_primitive(const FlowPrimitive& primitive, const Section& section) {
  check_place({primitive.centre_in_world_m.x, primitive.centre_in_world_m.y, 0}, "centre_in_world_m", section);
  for (const double speed : {primitive.velocity_mps.x, primitive.velocity_mps.y, primitive.velocity_mps.z}) {
    section.require_between(speed, -100, 100, "velocity_mps");
  }
  section.require_between(primitive.strength_m2ps, -1e5, 1e5, "strength_m2ps");
  section.require_between(primitive.core_radius_m, 0.01, 1e4, "core_radius_m");
}

void check_gust(const GustFront& gust, const Section& section) {
  section.require_between(gust.amplitude_mps, -100, 100, "amplitude_mps");
  section.require_between(gust.direction_from_deg, -360, 360, "direction_from_deg");
  section.require_between(gust.speed_mps, 0.1, 100, "speed_mps");
  section.require_between(gust.length_m, 0.1, 1e5, "length_m");
  section.require_between(gust.start_s, -1e6, 1e9, "start_s");
}

}  // namespace

void find_problems(const WindOptions& options, const Report& report) {
  if (options.turbulence) check_turbulence(*options.turbulence, {"wind", 0, report});
  if (options.recording) {
    const Section section("wind.recording", 0, report);
    section.require(!options.turbulence, "", "takes the place of turbulence: give one of the two");
    check_recording(*options.recording, section);
  }
  for (std::size_t i = 0; i < options.primitives.size(); ++i) {
    check_primitive(options.primitives[i], {"wind.primitive", i, report});
  }
  for (std::size_t i = 0; i < options.gusts.size(); ++i) check_gust(options.gusts[i], {"wind.gust", i, report});
}

Result<void> check(const WindOptions& options) {
  std::optional<Error> first;
  find_problems(options, [&first](const WindProblem& problem) {
    if (first) return;
    const bool is_one_of_many = problem.section == "wind.primitive" || problem.section == "wind.gust";
    const std::string section =
        is_one_of_many ? fmt::format("{}[{}]", problem.section, problem.index) : std::string(problem.section);
    first =
        Error{ErrorCode::invalid_argument,
              problem.key.empty() ? section + " " + problem.what : fmt::format("{}.{} {}", section, problem.key, problem.what)};
  });
  if (first) return *first;
  return {};
}

Vec3 mean_wind_mps(const WindOptions& options) {
  if (options.recording) return mean_mps(options.recording->samples_mps);
  Vec3 mean;
  if (options.turbulence) {
    const Vec3 along = towards_from_direction(options.turbulence->direction_from_deg);
    const double speed_mps = options.turbulence->mean_speed_mps;
    mean = {speed_mps * along.x, speed_mps * along.y, 0};
    if (speed_mps > 0) return mean;
  }
  for (const FlowPrimitive& primitive : options.primitives) {
    if (primitive.kind != FlowKind::uniform) continue;
    mean = {mean.x + primitive.velocity_mps.x, mean.y + primitive.velocity_mps.y, mean.z + primitive.velocity_mps.z};
  }
  return mean;
}

Result<std::shared_ptr<const WindField>> make_wind(const WindOptions& options, std::uint64_t seed, const WindRegion& region) {
  if (auto checked = check(options); !checked) return checked.error();
  std::vector<std::shared_ptr<const WindField>> winds;
  if (options.turbulence && options.turbulence->mean_speed_mps > 0) {
    auto turbulence = TurbulentWind::make(*options.turbulence, seed, region);
    if (!turbulence) return turbulence.error();
    winds.push_back(*turbulence);
  }
  if (options.recording) {
    auto recording = RecordedWind::make(*options.recording, region);
    if (!recording) return recording.error();
    winds.push_back(*recording);
  }
  if (!options.primitives.empty()) {
    winds.push_back(std::make_shared<FlowPrimitives>(options.primitives, mean_wind_mps(options)));
  }
  if (!options.gusts.empty()) winds.push_back(std::make_shared<GustFronts>(options.gusts));
  if (winds.size() == 1) return winds.front();
  return std::shared_ptr<const WindField>(std::make_shared<SumOfWinds>(std::move(winds)));
}

}  // namespace roseau::synthesis
