#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "synthesis/scene.h"
#include "synthesis/scene_fields.h"
#include "synthesis/scene_instruments.h"

namespace roseau::synthesis {

namespace {

// ---- the tree

void describe_grown(SceneFields& fields, structure::GrownTreeOptions& grown) {
  fields.whole("seed", grown.seed, 0, std::numeric_limits<std::int64_t>::max());
  fields.number("height_m", grown.height_m, 0.5, 40);
  fields.number("trunk_radius_m", grown.trunk_radius_m, grown.height_m / 500, grown.height_m / 5);
  fields.number("crown_base_m", grown.crown_base_m, 0, 0.8 * grown.height_m);
  fields.number("crown_width_m", grown.crown_width_m, 0.1, 2 * grown.height_m);
  fields.whole("main_branch_count", grown.main_branch_count, 1, 200);
  fields.whole("branching_orders", grown.branching_orders, 1, 4);
  fields.whole("leaf_count", grown.leaf_count, 0, 500000);
  fields.number("leaf_length_m", grown.leaf_length_m, 0.005, 1);
  fields.number("leaf_width_m", grown.leaf_width_m, 0.005, 1);
}

void describe_cantilever(SceneFields& fields, structure::CantileverOptions& pole) {
  fields.number("length_m", pole.length_m, 0.1, 40);
  fields.number("start_radius_m", pole.start_radius_m, 1e-4, 2);
  fields.number("end_radius_m", pole.end_radius_m, 1e-4, 2);
  fields.whole("segment_count", pole.segment_count, 1, 1000);
  fields.whole("board_leaves", pole.board_leaves, 0, 200);
  fields.number("board_length_m", pole.board_length_m, 0.01, 10);
  fields.number("board_width_m", pole.board_width_m, 0.01, 10);
  fields.number("board_disorder", pole.board_disorder, 0, 1);
}

void describe_tree(SceneFields& fields, TreeScene& tree) {
  static constexpr std::array<std::string_view, 3> kKinds{"grown", "cantilever", "file"};
  fields.word("kind", tree.kind, kKinds);
  fields.text("file", tree.file);
  fields.require((tree.kind == "file") == !tree.file.empty(), "file", "must be given when kind is \"file\", and only then");
  fields.whole("node_limit", tree.node_limit, 2, 20000);
  fields.section("grown", [&](SceneFields& inner) { describe_grown(inner, tree.grown); });
  fields.section("cantilever", [&](SceneFields& inner) { describe_cantilever(inner, tree.cantilever); });
}

void describe_mechanics(SceneFields& fields, MechanicsScene& mechanics) {
  static constexpr std::array<std::string_view, 2> kLoads{"full", "projection"};
  static constexpr std::array<std::string_view, 2> kSteppings{"exact", "semi_implicit"};
  fields.whole("mode_count", mechanics.mode_count, 1, 400);
  fields.number("young_modulus_gpa", mechanics.young_modulus_gpa, 0.001, 1000);
  fields.number("wood_density_kg_m3", mechanics.wood_density_kg_m3, 1, 20000);
  fields.number("leaf_mass_kg_m2", mechanics.leaf_mass_kg_m2, 0, 100);
  fields.number("mass_factor", mechanics.mass_factor, 0.01, 100);
  fields.number("damping_alpha_per_s", mechanics.damping_alpha_per_s, 0, 100);
  fields.number("damping_beta_s", mechanics.damping_beta_s, 0, 10);
  fields.word("load", mechanics.load, kLoads);
  fields.word("stepping", mechanics.stepping, kSteppings);
  fields.number("step_rate_hz", mechanics.step_rate_hz, 20, 5000);
}

void describe_drag(SceneFields& fields, DragScene& drag) {
  fields.number("air_density_kg_m3", drag.air_density_kg_m3, 0, 2000);
  fields.number("wood_coefficient", drag.wood_coefficient, 0, 10);
  fields.number("leaf_coefficient", drag.leaf_coefficient, 0, 10);
  fields.number("leaf_vogel_exponent", drag.leaf_vogel_exponent, -1.9, 0);
  fields.number("reference_speed_mps", drag.reference_speed_mps, 0.1, 100);
  fields.flag("relative_velocity", drag.relative_velocity);
}

void describe_targets(Scene& scene, SceneFields& fields) {
  std::set<std::string> names;
  fields.list<TargetScene>("target", scene.targets, 0, 16, [&](SceneFields& inner, TargetScene& target) {
    inner.text("name", target.name);
    constexpr std::string_view kAllowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_.";
    inner.require(!target.name.empty() && target.name.find_first_not_of(kAllowed) == std::string::npos, "name",
                  "must be letters, digits, '-', '_' and '.'");
    inner.require(names.insert(target.name).second, "name", "is another target's, too");
    inner.point("near_in_world_m", target.near_in_world_m);
    inner.number("width_m", target.width_m, 0.01, 100);
    inner.number("height_m", target.height_m, 0.01, 100);
  });
}

void describe_balls(SceneFields& fields, BallsScene& balls) {
  fields.flag("enabled", balls.enabled);
  fields.number("diameter_m", balls.diameter_m, 0.01, 1);
  fields.numbers("near_in_world_m", balls.near_in_world_m);
  fields.require(balls.near_in_world_m.size() % 3 == 0 && balls.near_in_world_m.size() <= 48, "near_in_world_m",
                 "must be three numbers (x, y, z) for each of at most 16 balls");
}

void describe_pull(SceneFields& fields, PullScene& pull) {
  fields.point("near_in_world_m", pull.near_in_world_m);
  fields.point("force_n", pull.force_n);
  fields.number("start_s", pull.start_s, 0, 1e6);
  fields.number("full_s", pull.full_s, 0, 1e6);
  fields.number("release_s", pull.release_s, 0, 1e6);
  fields.require(pull.start_s < pull.full_s && pull.full_s <= pull.release_s, "full_s",
                 "must come after start_s and not after release_s");
}

// ---- the wind

template <class Enum>
void word_of(SceneFields& fields, std::string_view key, Enum& value, std::initializer_list<Enum> all) {
  std::vector<std::string_view> allowed;
  for (const Enum one : all) allowed.push_back(to_string(one));
  std::string chosen(to_string(value));
  fields.word(key, chosen, allowed);
  for (const Enum one : all) {
    if (to_string(one) == chosen) value = one;
  }
}

void describe_gust(SceneFields& fields, GustFront& gust) {
  word_of(fields, "shape", gust.shape, {GustShape::one_minus_cos, GustShape::ramp});
  fields.number("amplitude_mps", gust.amplitude_mps, -60, 60);
  fields.number("direction_from_deg", gust.direction_from_deg, -360, 360);
  fields.number("speed_mps", gust.speed_mps, 0.1, 100);
  fields.number("length_m", gust.length_m, 0.1, 10000);
  fields.number("start_s", gust.start_s, -1e6, 1e6);
}

void describe_primitive(SceneFields& fields, FlowPrimitive& flow) {
  word_of(fields, "kind", flow.kind, {FlowKind::uniform, FlowKind::vortex, FlowKind::source});
  fields.point("velocity_mps", flow.velocity_mps);
  std::vector<double> centre{flow.centre_in_world_m.x, flow.centre_in_world_m.y};
  fields.numbers("centre_in_world_m", centre);
  fields.require(centre.size() == 2, "centre_in_world_m", "must be two numbers: x (east) and y (north)");
  if (centre.size() == 2) flow.centre_in_world_m = {centre[0], centre[1]};
  fields.number("strength_m2ps", flow.strength_m2ps, -1e4, 1e4);
  fields.number("core_radius_m", flow.core_radius_m, 0.01, 1000);
  fields.flag("drifts_with_wind", flow.drifts_with_wind);
}

void describe_turbulence(SceneFields& fields, TurbulentWindOptions& wind) {
  fields.number("mean_speed_mps", wind.mean_speed_mps, 0, 60);
  fields.number("direction_from_deg", wind.direction_from_deg, -360, 360);
  fields.number("turbulence_intensity", wind.turbulence_intensity, 0, 1);
  fields.number("across_sd_ratio", wind.across_sd_ratio, 0, 3);
  fields.number("vertical_sd_ratio", wind.vertical_sd_ratio, 0, 3);
  word_of(fields, "spectrum", wind.spectrum, {TurbulenceSpectrum::von_karman, TurbulenceSpectrum::kaimal});
  fields.number("length_scale_m", wind.length_scale_m, 0.1, 5000);
  fields.number("across_length_scale_m", wind.across_length_scale_m, 0.1, 5000);
  fields.number("vertical_length_scale_m", wind.vertical_length_scale_m, 0.1, 5000);
  fields.number("lateral_decay", wind.lateral_decay, 0, 100);
  fields.number("vertical_decay", wind.vertical_decay, 0, 100);
  word_of(fields, "profile", wind.profile, {ProfileShape::uniform, ProfileShape::power, ProfileShape::logarithmic});
  fields.number("reference_height_m", wind.reference_height_m, 0.1, 200);
  fields.number("profile_exponent", wind.profile_exponent, 0, 1);
  fields.number("roughness_length_m", wind.roughness_length_m, 1e-5, 10);
  fields.number("displacement_height_m", wind.displacement_height_m, 0, 100);
  fields.number("strand_spacing_m", wind.strand_spacing_m, 0.05, 100);
  fields.number("period_s", wind.period_s, 32, 20000);
}

void describe_wind(SceneFields& fields, WindScene& wind) {
  describe_turbulence(fields, wind.turbulence);
  fields.section("recording", [&](SceneFields& inner) {
    inner.text("file", wind.recording.file);
    inner.text("topic", wind.recording.topic);
    inner.point("place_in_world_m", wind.recording.place_in_world_m);
    inner.number("start_s", wind.recording.start_s, 0, 1e7);
    inner.flag("loop", wind.recording.loop);
  });
  fields.list<FlowPrimitive>("primitive", wind.primitives, 0, 32, describe_primitive);
  fields.list<GustFront>("gust", wind.gusts, 0, 32, describe_gust);
}

// ---- instruments

std::size_t distortion_count(std::string_view lens) {
  return lens == "pinhole" ? 0 : lens == "opencv4" ? 4 : lens == "opencv5" ? 5 : 8;
}

void describe_camera(SceneFields& fields, CameraScene& camera) {
  static constexpr std::array<std::string_view, 3> kFormats{"bgr8", "rgb8", "mono8"};
  static constexpr std::array<std::string_view, 4> kLenses{"pinhole", "opencv4", "opencv5", "opencv8"};
  static constexpr std::array<std::string_view, 2> kStamps{"host", "device"};
  fields.whole("width_px", camera.width_px, 64, 4096);
  fields.whole("height_px", camera.height_px, 64, 4096);
  std::string format(to_string(camera.format));
  fields.word("format", format, kFormats);
  if (const auto known = pixel_format_from_string(format)) camera.format = *known;
  fields.word("lens", camera.lens, kLenses);
  fields.number("focal_length_px", camera.focal_length_px, 50, 50000);
  fields.numbers("distortion", camera.distortion);
  fields.require(camera.distortion.size() <= distortion_count(camera.lens), "distortion",
                 fmt::format("must be at most {} numbers for lens {}", distortion_count(camera.lens), camera.lens));
  fields.point("position_in_world_m", camera.position_in_world_m);
  fields.point("look_at_in_world_m", camera.look_at_in_world_m);
  const Vec3& from = camera.position_in_world_m;
  const Vec3& to = camera.look_at_in_world_m;
  fields.require(to.y - from.y > std::hypot(to.x - from.x, to.z - from.z), "look_at_in_world_m",
                 "must be to the north of the camera, within 45 degrees");
  fields.number("rate_hz", camera.rate_hz, 0.1, 1000);
  fields.number("exposure_duration_s", camera.exposure_duration_s, 0, 1);
  fields.require(camera.exposure_duration_s * camera.rate_hz <= 1, "exposure_duration_s",
                 "must not be longer than the time between two frames");
  fields.whole("exposure_taps", camera.exposure_taps, 1, 64);
  fields.number("line_delay_s", camera.line_delay_s, 0, 0.01);
  fields.require(camera.line_delay_s * camera.height_px * camera.rate_hz <= 1, "line_delay_s",
                 "makes a frame's rows take longer than the time between two frames");
  fields.number("lens_blur_px", camera.lens_blur_px, 0, 10);
  fields.number("gain", camera.gain, 0.01, 100);
  fields.number("read_noise_counts", camera.read_noise_counts, 0, 100);
  fields.number("shot_noise_gain", camera.shot_noise_gain, 0, 10);
  fields.word("stamps", camera.stamps, kStamps);
  describe_timing(fields, camera.timing);
}

void describe_background(SceneFields& fields, BackgroundScene& background) {
  fields.flag("visible", background.visible);
  fields.number("hedge_sway_m", background.hedge_sway_m, 0, 2);
  fields.number("cloud_speed_mps", background.cloud_speed_mps, 0, 100);
  fields.number("light_change", background.light_change, 0, 0.9);
  fields.number("light_period_s", background.light_period_s, 1, 3600);
}

void describe_bar_rig(SceneFields& fields, BarRigScene& rig) {
  fields.flag("enabled", rig.enabled);
  fields.number("speed_mps", rig.speed_mps, 0.01, 5);
  fields.number("sag_m", rig.sag_m, 0, 0.5);
  fields.number("survey_error_m", rig.survey_error_m, 0, 0.1);
  fields.number("tag_size_m", rig.tag_size_m, 0.02, 1);
  fields.point("volume_low_in_world_m", rig.volume_low_in_world_m);
  fields.point("volume_high_in_world_m", rig.volume_high_in_world_m);
  const Vec3& low = rig.volume_low_in_world_m;
  const Vec3& high = rig.volume_high_in_world_m;
  fields.require(low.x < high.x && low.y < high.y && low.z < high.z, "volume_high_in_world_m",
                 "must be above volume_low_in_world_m in each coordinate");
}

}  // namespace

void describe(Scene& scene, SceneFields& fields) {
  fields.whole("seed", scene.seed, 0, std::numeric_limits<std::int64_t>::max());
  fields.section("wind", [&](SceneFields& inner) { describe_wind(inner, scene.wind); });
  fields.section("tree", [&](SceneFields& inner) { describe_tree(inner, scene.tree); });
  fields.section("mechanics", [&](SceneFields& inner) { describe_mechanics(inner, scene.mechanics); });
  fields.section("drag", [&](SceneFields& inner) { describe_drag(inner, scene.drag); });
  describe_targets(scene, fields);
  fields.section("balls", [&](SceneFields& inner) { describe_balls(inner, scene.balls); });
  fields.list<PullScene>("pull", scene.pulls, 0, 100, describe_pull);
  fields.list<CameraScene>("camera", scene.cameras, 1, 8, describe_camera);
  fields.section("sonic", [&](SceneFields& inner) { describe_sonic(inner, scene.sonic); });
  fields.section("tracker", [&](SceneFields& inner) { describe_tracker(inner, scene.tracker); });
  fields.section("led_board", [&](SceneFields& inner) { describe_led_board(inner, scene.led_board); });
  fields.section("background", [&](SceneFields& inner) { describe_background(inner, scene.background); });
  fields.section("bar_rig", [&](SceneFields& inner) { describe_bar_rig(inner, scene.bar_rig); });
  fields.section("truth", [&](SceneFields& inner) {
    inner.flag("enabled", scene.truth.enabled);
    inner.number("wind_rate_hz", scene.truth.wind_rate_hz, 0.1, 1000);
    inner.number("marker_rate_hz", scene.truth.marker_rate_hz, 0.1, 1000);
  });
}

}  // namespace roseau::synthesis
