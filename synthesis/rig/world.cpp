#include "synthesis/rig/world.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "structure/mechanics/drag_load.h"
#include "structure/mechanics/modal_model.h"
#include "structure/mechanics/sway_truth.h"
#include "structure/mechanics/wind_projection.h"
#include "structure/tree/branches.h"
#include "synthesis/instruments/rotation.h"
#include "synthesis/wind/wind_options.h"

namespace roseau::synthesis {

namespace {

constexpr std::uint64_t kCameraStreams = 1000;
constexpr double kBallMass_kg = 0.03;  // of a hollow ball with the receiver in it
constexpr double kMostMemory_bytes = 4e9;
constexpr double kFrameBuffers = 48;
// A tree starts in equilibrium with the wind; what that was wrong by dies away over this many time constants.
constexpr double kForgottenAfter = 12;
constexpr double kLongestSettling_s = 60;
constexpr double kShortestSettling_s = 5;

structure::BeamOptions beam_options(const Scene& scene, const std::vector<PlacedBall>& balls) {
  structure::BeamOptions options;
  options.material.young_modulus_pa = scene.mechanics.young_modulus_gpa * 1e9;
  options.material.density_kg_m3 = scene.mechanics.wood_density_kg_m3;
  options.material.leaf_mass_per_area_kg_m2 = scene.mechanics.leaf_mass_kg_m2;
  for (const PlacedBall& ball : balls) options.point_masses.push_back({static_cast<std::uint32_t>(ball.node), kBallMass_kg});
  return options;
}

structure::DragOptions drag_options(const DragScene& drag) {
  structure::DragOptions options;
  options.air_density_kg_m3 = drag.air_density_kg_m3;
  options.wood_coefficient = drag.wood_coefficient;
  options.foliage_coefficient = drag.leaf_coefficient;
  options.foliage_vogel_exponent = drag.leaf_vogel_exponent;
  options.reference_speed_mps = drag.reference_speed_mps;
  options.relative_velocity = drag.relative_velocity;
  return options;
}

WindOptions wind_options(const WindScene& wind) {
  WindOptions options;
  if (wind.recording.samples_mps.empty()) {
    if (wind.turbulence.mean_speed_mps > 0) {
      options.turbulence = wind.turbulence;
    } else {
      options.turbulence.reset();
    }
  } else {
    options.turbulence.reset();
    options.recording = {.samples_mps = wind.recording.samples_mps,
                         .rate_hz = wind.recording.rate_hz,
                         .place_in_world_m = wind.recording.place_in_world_m,
                         .start_s = wind.recording.start_s,
                         .at_end = wind.recording.loop ? RecordingEnd::loop : RecordingEnd::refuse,
                         .profile = wind.turbulence.profile,
                         .profile_exponent = wind.turbulence.profile_exponent,
                         .roughness_length_m = wind.turbulence.roughness_length_m,
                         .displacement_height_m = wind.turbulence.displacement_height_m};
  }
  options.primitives = wind.primitives;
  options.gusts = wind.gusts;
  return options;
}

WindRegion region_of(std::span<const Vec3> points, const Scene& scene) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  WindRegion::Box box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (const Vec3& point : points) {
    box.low_in_world_m = {std::min(box.low_in_world_m.x, point.x), std::min(box.low_in_world_m.y, point.y),
                          std::min(box.low_in_world_m.z, point.z)};
    box.high_in_world_m = {std::max(box.high_in_world_m.x, point.x), std::max(box.high_in_world_m.y, point.y),
                           std::max(box.high_in_world_m.z, point.z)};
  }
  return {.crown = box, .instruments_in_world_m = {scene.sonic.position_in_world_m}, .duration_s = 0};
}

double settling_s(const Scene& scene, const structure::ModalModel& model) {
  if (scene.wind.turbulence.mean_speed_mps == 0 && scene.wind.recording.samples_mps.empty()) return kShortestSettling_s;
  const double slowest_decay_per_s = std::max(model.damping_coefficient_per_s().minCoeff() / 2, 1e-9);
  return std::clamp(kForgottenAfter / slowest_decay_per_s, kShortestSettling_s, kLongestSettling_s);
}

}  // namespace

Result<std::shared_ptr<const World>> World::build(const Scene& scene) {
  if (auto checked = check(scene); !checked) return checked.error();
  std::shared_ptr<World> world(new World);
  world->scene_ = scene;
  for (const CameraScene& camera : scene.cameras) world->cameras_.emplace_back(model_of(camera));
  if (scene.led_board.enabled) world->led_board_.emplace("led_board", scene.led_board.instrument, scene.seed);
  if (scene.bar_rig.enabled) world->bar_rig_.emplace(scene.bar_rig, scene.seed);
  if (auto made = world->make_tree(); !made) return made.error();
  if (auto made = world->make_motion(); !made) return made.error();
  if (auto made = world->make_visible(); !made) return made.error();
  return std::shared_ptr<const World>(std::move(world));
}

Result<void> World::make_tree() {
  if (scene_.tree.kind == "file") {
    if (!scene_.tree.model) return Error{ErrorCode::invalid_argument, "scene: tree: the file has not been read"};
    tree_ = *scene_.tree.model;
    scene_.tree.model.reset();
  } else {
    auto tree =
        scene_.tree.kind == "grown" ? structure::grow_tree(scene_.tree.grown) : structure::cantilever(scene_.tree.cantilever);
    if (!tree) return tree.error().with_context("scene: tree");
    tree_ = std::move(*tree);
  }
  double frame_bytes = 0;
  for (const CameraScene& camera : scene_.cameras) {
    frame_bytes += kFrameBuffers * camera.width_px * camera.height_px * static_cast<double>(bytes_per_pixel(camera.format));
  }
  const double bytes = frame_bytes + structure::modal_analysis_bytes(tree_.nodes.size(), scene_.mechanics.mode_count);
  if (bytes > kMostMemory_bytes) {
    return Error{ErrorCode::invalid_argument,
                 fmt::format("scene: {} nodes with {} modes and the cameras' frames need {:.1f} GB, more than the {:.0f} GB a "
                             "scene may use: lower tree.node_limit, mechanics.mode_count or the cameras' sizes",
                             tree_.nodes.size(), scene_.mechanics.mode_count, bytes * 1e-9, kMostMemory_bytes * 1e-9)};
  }
  place_balls();
  return {};
}

void World::place_balls() {
  for (std::size_t i = 0; i < scene_.balls.count(); ++i) {
    const auto& near = scene_.balls.near_in_world_m;
    const std::size_t node = structure::nearest_node(tree_, {near[3 * i], near[3 * i + 1], near[3 * i + 2]});
    balls_.push_back({fmt::format("ball{}", i + 1), node, tree_.nodes[node].position_m});
  }
}

Result<void> World::make_motion() {
  const MechanicsScene& mechanics = scene_.mechanics;
  structure::ModalParameters parameters;
  parameters.mass_factor = mechanics.mass_factor;
  parameters.alpha_per_s = mechanics.damping_alpha_per_s;
  parameters.beta_s = mechanics.damping_beta_s;
  auto model =
      structure::ModalModel::build(tree_, beam_options(scene_, balls_), {.mode_count = mechanics.mode_count}, parameters);
  if (!model) return model.error().with_context("scene: mechanics");
  auto load = structure::DragLoad::build(tree_, *model, drag_options(scene_.drag));
  if (!load) return load.error().with_context("scene: drag");
  const WindOptions options = wind_options(scene_.wind);
  auto wind = make_wind(options, scene_.seed, region_of(load->points_in_world(), scene_));
  if (!wind) return wind.error().with_context("scene: wind");
  wind_ = std::move(*wind);
  wind_point_ = structure::WindProjection(*load).centre_in_world();
  place_targets(*load, *model);

  structure::SwayOptions sway;
  sway.step_s = 1 / mechanics.step_rate_hz;
  sway.start_s = -settling_s(scene_, *model);
  sway.load =
      mechanics.load == "full" ? structure::SwayOptions::Load::full_integration : structure::SwayOptions::Load::projection;
  sway.stepping =
      mechanics.stepping == "exact" ? structure::SwayOptions::Stepping::exact : structure::SwayOptions::Stepping::semi_implicit;
  sway.mean_wind_mps = mean_wind_mps(options);
  for (const PullScene& pull : scene_.pulls) {
    sway.pulls.push_back({.node = structure::nearest_node(tree_, pull.near_in_world_m),
                          .force_n = pull.force_n,
                          .start_s = pull.start_s,
                          .ramp_s = pull.full_s - pull.start_s,
                          .release_s = pull.release_s});
  }
  auto simulation = structure::SwaySimulation::make(std::move(*model), std::move(*load), *wind_, sway);
  if (!simulation) return simulation.error().with_context("scene: mechanics");
  tree_motion_ = std::make_unique<const TreeMotion>(std::move(*simulation));
  // What lies before time 0 is computed now, not while devices wait for their first sample.
  Eigen::VectorXd amplitudes;
  tree_motion_->amplitudes(0, amplitudes);
  return {};
}

Eigen::Matrix3Xd World::shape_of_region(const TargetScene& target, const Vec3& middle,
                                        const structure::ModalModel& model) const {
  std::vector<double> weights = structure::leaf_area_by_node_m2(tree_);
  double total = 0;
  for (std::size_t node = 0; node < tree_.nodes.size(); ++node) {
    const Vec3& place = tree_.nodes[node].position_m;
    const bool is_inside =
        std::abs(place.x - middle.x) <= target.width_m / 2 && std::abs(place.z - middle.z) <= target.height_m / 2;
    if (!is_inside) weights[node] = 0;
    total += weights[node];
  }
  if (total == 0) {  // bare wood: the one node
    weights[structure::nearest_node(tree_, middle)] = 1;
    total = 1;
  }
  const auto modes = static_cast<Eigen::Index>(model.mode_count());
  Eigen::Matrix3Xd shape = Eigen::Matrix3Xd::Zero(3, modes);
  for (std::size_t node = 0; node < tree_.nodes.size(); ++node) {
    if (weights[node] > 0) {
      shape += weights[node] / total * model.translations().middleRows(3 * static_cast<Eigen::Index>(node), 3);
    }
  }
  return shape;
}

void World::place_targets(const structure::DragLoad& load, const structure::ModalModel& model) {
  const Vec3 mean = mean_wind_mps(wind_options(scene_.wind));
  const auto in_wind = structure::linearised_modes(model, load.damping_matrix(mean));
  const bool is_calm = std::hypot(mean.x, mean.y) == 0;
  const Eigen::Vector3d push = is_calm ? Eigen::Vector3d::UnitX() : Eigen::Vector3d(mean.x, mean.y, 0).normalized();
  Eigen::VectorXd force(static_cast<Eigen::Index>(model.mode_count()));
  structure::WindProjection(load).modal_force({push.x(), push.y(), 0}, force);
  for (const TargetScene& wanted : scene_.targets) {
    PlacedTarget target;
    target.name = wanted.name;
    target.rest_in_world_m = tree_.nodes[structure::nearest_node(tree_, wanted.near_in_world_m)].position_m;
    target.width_m = wanted.width_m;
    target.height_m = wanted.height_m;
    target.shape = shape_of_region(wanted, target.rest_in_world_m, model);
    const Eigen::ArrayXd shares = (target.shape.transpose() * push).array() * force.array() / model.stiffness_per_s2();
    Eigen::Index mode = 0;
    shares.abs().maxCoeff(&mode);
    target.mode = static_cast<std::size_t>(mode);
    target.natural_frequency_hz = in_wind[target.mode].natural_frequency_hz;
    target.damping_ratio = in_wind[target.mode].damping_ratio;
    Eigen::Vector3d axis = target.shape.col(mode);
    axis = axis.norm() > 0 ? Eigen::Vector3d(axis.normalized()) : push;
    if (axis.dot(push) < 0) axis = -axis;
    target.axis = {axis.x(), axis.y(), axis.z()};
    targets_.push_back(std::move(target));
  }
}

Result<void> World::make_visible() {
  render::SceneDescription description;
  description.tree = tree_;
  for (std::size_t i = 0; i < balls_.size(); ++i) {
    description.balls.push_back({.node = static_cast<std::uint32_t>(balls_[i].node),
                                 .diameter_m = scene_.balls.diameter_m,
                                 .colour = render::kMarkerColours[i % render::kMarkerColours.size()]});
  }
  if (scene_.bar_rig.enabled) {
    description.bar_rig.emplace();
    description.bar_rig->tag_size_m = scene_.bar_rig.tag_size_m;
    description.bar_rig->back_tags = {6, 7, 8, 9, 10, 11};
  }
  if (led_board_) {
    description.led_board = render::LedBoard{.centre_in_world_m = scene_.led_board.centre_in_world_m,
                                             .pitch_m = scene_.led_board.pitch_m,
                                             .led_diameter_m = 0.6 * scene_.led_board.pitch_m,
                                             .tick_duration_s = led_board_->tick_s()};
  }
  description.sonic = render::SonicMast{.position_in_world_m = scene_.sonic.position_in_world_m};
  description.background.visible = scene_.background.visible;
  description.background.hedge_sway_m = scene_.background.hedge_sway_m;
  description.background.cloud_speed_mps = scene_.background.cloud_speed_mps;
  for (const CameraScene& camera : scene_.cameras) description.viewpoints_in_world_m.push_back(camera.position_in_world_m);
  description.seed = scene_.seed;
  auto visible = render::VisibleScene::create(std::move(description));
  if (!visible) return visible.error().with_context("scene");
  visible_ = std::move(*visible);
  return {};
}

SampleTimes World::camera_times(std::size_t index) const {
  const CameraScene& camera = scene_.cameras.at(index);
  return {camera.rate_hz, camera.timing, scene_.seed, kCameraStreams + index};
}

WindSample World::wind_in_sonic_axes(const Vec3& point_in_world_m, double time_s) const {
  const Vec3 air = wind_->velocity_mps(point_in_world_m, time_s);
  const Vec3 level = wind_in_head_axes(scene_.sonic, air, Mounting::level);
  WindSample sample{.u_mps = level.x, .v_mps = level.y, .w_mps = level.z};
  sample.sonic_temperature_celsius = air_temperature_celsius(scene_.sonic, air.z);
  sample.speed_of_sound_mps = speed_of_sound_mps(sample.sonic_temperature_celsius);
  return sample;
}

StationPlace World::station_place(std::size_t station, double time_s) const {
  Eigen::VectorXd amplitudes;
  tree_motion_->amplitudes(time_s, amplitudes);
  const std::size_t ball = station - 1;
  return {.position_in_world_m = ball_in_world_m(ball, amplitudes),
          .world_from_station =
              quaternion_from_rotation_vector(tree_motion_->model().rotation_rad(balls_.at(ball).node, amplitudes))};
}

Vec3 World::ball_in_world_m(std::size_t ball, const Eigen::VectorXd& amplitudes) const {
  const PlacedBall& placed = balls_.at(ball);
  return placed.rest_in_world_m + tree_motion_->model().displacement_m(placed.node, amplitudes);
}

double World::light_level(double time_s) const {
  const BackgroundScene& background = scene_.background;
  const double phase = 2 * std::numbers::pi * time_s / background.light_period_s;
  return 1 + background.light_change * 0.5 * (std::sin(phase) + std::sin(phase * std::numbers::sqrt2 + 1));
}

void World::fill_moment(double time_s, Eigen::VectorXd& amplitudes, render::SceneMoment& moment) const {
  tree_motion_->amplitudes(time_s, amplitudes);
  const structure::ModalModel& model = tree_motion_->model();
  static_assert(sizeof(Vec3) == 3 * sizeof(double), "a row of vectors is a row of numbers");
  const auto rows = static_cast<Eigen::Index>(3 * tree_.nodes.size());
  Eigen::Map<Eigen::VectorXd>(&moment.displacement_m.front().x, rows).noalias() = model.translations() * amplitudes;
  Eigen::Map<Eigen::VectorXd>(&moment.rotation_rad.front().x, rows).noalias() = model.rotations() * amplitudes;
  moment.light_level = light_level(time_s);
  const Vec3 air = wind_->velocity_mps(wind_point_, time_s);
  moment.background_sway = std::min(2.0, std::hypot(air.x, air.y) / 5);
  if (led_board_) moment.board_time_s = led_board_->clock().device_time_s(time_s);
  if (bar_rig_) bar_rig_->fill(time_s, moment.rig);
}

Vec2 World::target_displacement_px(const PlacedTarget& target, std::size_t camera, const Vec3& displacement_m) const {
  const Vec2 rest = cameras_.at(camera).project(target.rest_in_world_m);
  const Vec2 now = cameras_.at(camera).project(target.rest_in_world_m + displacement_m);
  return {now.x - rest.x, now.y - rest.y};
}

ImageRect World::target_region(const PlacedTarget& target, std::size_t camera, const Vec3& displacement_m) const {
  const calib::CameraModel& model = cameras_.at(camera).camera();
  const Vec3 centre = target.rest_in_world_m + displacement_m;
  const Vec2 middle = cameras_.at(camera).project(centre);
  const double depth_m = calib::to_camera(model, centre).z;
  const double width_px = target.width_m * model.fx_px() / depth_m;
  const double height_px = target.height_m * model.fy_px() / depth_m;
  return {middle.x - width_px / 2 + 0.5, middle.y - height_px / 2 + 0.5, width_px, height_px};  // from pixel centres to corners
}

}  // namespace roseau::synthesis
