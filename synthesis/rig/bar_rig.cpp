#include "synthesis/rig/bar_rig.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"
#include "synthesis/instruments/rotation.h"
#include "synthesis/scene.h"

namespace roseau::synthesis {

namespace {

constexpr std::uint64_t kPathStream = 7100;
constexpr std::uint64_t kSurveyStream = 7101;
constexpr double kGolden = 1.6180339887498949;
constexpr double kPitchReach_rad = 0.5;
constexpr double kRollReach_rad = 0.8;
constexpr double kTurnPeriod_s = 45;  // once round the vertical
constexpr double kBarMiddle_m = (BarRigMotion::kLongBarBegin_m + BarRigMotion::kLongBarEnd_m) / 2;
constexpr double kHalfBar_m = (BarRigMotion::kLongBarEnd_m - BarRigMotion::kLongBarBegin_m) / 2;

}  // namespace

double BarRigMotion::Wave::at(double time_s) const {
  const double phase = rate_rad_s * time_s + phase_rad;
  return middle + reach * (0.7 * std::sin(phase) + 0.3 * std::sin(phase / kGolden + 1));
}

BarRigMotion::BarRigMotion(const BarRigScene& scene, std::uint64_t seed) : sag_m_(scene.sag_m) {
  const RandomStream path(seed, kPathStream);
  const RandomStream survey(seed, kSurveyStream);
  const auto phase = [&path](std::uint64_t i) { return path.uniform(i, 0, 2 * std::numbers::pi); };
  const std::array low{scene.volume_low_in_world_m.x, scene.volume_low_in_world_m.y, scene.volume_low_in_world_m.z};
  const std::array high{scene.volume_high_in_world_m.x, scene.volume_high_in_world_m.y, scene.volume_high_in_world_m.z};
  // What the ends of the tilted bar need above and below its middle.
  const std::array margin_m{0.3, 0.3, kHalfBar_m * std::sin(kPitchReach_rad)};
  for (std::size_t i = 0; i < 3; ++i) {
    const double half = (high[i] - low[i]) / 2;
    const double reach = std::max(half - margin_m[i], 0.1 * half);
    // The fastest of a sine is its reach times its rate.
    const double rate = scene.speed_mps / (std::numbers::sqrt3 * reach) * std::pow(kGolden, 0.4 * (static_cast<double>(i) - 1));
    middle_.at(i) = {.middle = (low[i] + high[i]) / 2, .reach = reach, .rate_rad_s = rate, .phase_rad = phase(i)};
  }
  pitch_ = {.reach = kPitchReach_rad, .rate_rad_s = 0.31, .phase_rad = phase(3)};
  roll_ = {.reach = kRollReach_rad, .rate_rad_s = 0.43, .phase_rad = phase(4)};
  yaw_ = {.middle = phase(5), .reach = 0.4, .rate_rad_s = 0.23, .phase_rad = phase(6)};
  yaw_rate_rad_s_ = 2 * std::numbers::pi / kTurnPeriod_s;
  true_in_rig_m_ = surveyed_in_rig_m();
  for (std::size_t i = 0; i < kTargets; ++i) {
    Vec3& point = true_in_rig_m_.at(i);
    point.x += scene.survey_error_m * survey.normal(3 * i);
    point.y += scene.survey_error_m * survey.normal(3 * i + 1);
    point.z += scene.survey_error_m * survey.normal(3 * i + 2);
  }
}

std::array<Vec3, BarRigMotion::kTargets> BarRigMotion::surveyed_in_rig_m() {
  return {Vec3{-0.8, 0, 0}, Vec3{0, 0, 0}, Vec3{1.7, 0, 0}, Vec3{3.8, 0, 0}, Vec3{0, -0.35, 0}, Vec3{0, 0.55, 0}};
}

BarRigMotion::Pose BarRigMotion::pose(double time_s) const {
  // At rest the bar lies east-west, the cross bar upright and the tags face south, where the cameras are.
  const Eigen::Quaterniond facing(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond world_from_rig =
      Eigen::AngleAxisd(yaw_.at(time_s) + yaw_rate_rad_s_ * time_s, Eigen::Vector3d::UnitZ()) *
      Eigen::AngleAxisd(pitch_.at(time_s), Eigen::Vector3d::UnitY()) *
      Eigen::AngleAxisd(roll_.at(time_s), Eigen::Vector3d::UnitX()) * facing;
  const Eigen::Vector3d middle(middle_[0].at(time_s), middle_[1].at(time_s), middle_[2].at(time_s));
  const Eigen::Vector3d junction = middle - world_from_rig * Eigen::Vector3d(kBarMiddle_m, 0, 0);
  return {.junction_in_world_m = {junction.x(), junction.y(), junction.z()},
          .world_from_rig = {world_from_rig.w(), world_from_rig.x(), world_from_rig.y(), world_from_rig.z()}};
}

Vec3 BarRigMotion::point_in_world_m(const Vec3& point_in_rig_m, double time_s) const {
  const Pose now = pose(time_s);
  const Vec3 turned = rotated(now.world_from_rig, point_in_rig_m);
  const Vec3 bar = rotated(now.world_from_rig, {1, 0, 0});
  // Held in the middle, a beam droops as the square of the distance, to first order, and less the steeper it stands.
  const double share = (point_in_rig_m.x - kBarMiddle_m) / kHalfBar_m;
  const double droop_m = sag_m_ * share * share * std::hypot(bar.x, bar.y);
  return {now.junction_in_world_m.x + turned.x, now.junction_in_world_m.y + turned.y,
          now.junction_in_world_m.z + turned.z - droop_m};
}

std::array<Vec3, BarRigMotion::kTargets> BarRigMotion::targets_in_world_m(double time_s) const {
  std::array<Vec3, kTargets> targets;
  for (std::size_t i = 0; i < kTargets; ++i) targets.at(i) = point_in_world_m(true_in_rig_m_.at(i), time_s);
  return targets;
}

void BarRigMotion::fill(double time_s, render::RigMoment& moment) const {
  constexpr int kPieces = 8;  // of the sagging bar
  moment.visible = true;
  moment.world_from_rig = pose(time_s).world_from_rig;
  const auto targets = targets_in_world_m(time_s);
  moment.targets_in_world_m.assign(targets.begin(), targets.end());
  moment.long_bar_in_world_m.resize(kPieces + 1);
  for (int i = 0; i <= kPieces; ++i) {
    const double x_m = std::lerp(kLongBarBegin_m, kLongBarEnd_m, static_cast<double>(i) / kPieces);
    moment.long_bar_in_world_m[static_cast<std::size_t>(i)] = point_in_world_m({x_m, 0, 0}, time_s);
  }
  moment.cross_bar_in_world_m = {point_in_world_m({0, kCrossBarBegin_m, 0}, time_s),
                                 point_in_world_m({0, kCrossBarEnd_m, 0}, time_s)};
}

}  // namespace roseau::synthesis
