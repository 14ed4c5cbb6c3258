#include "synthesis/oscillator/branch_motion.h"

#include <cmath>
#include <utility>

#include "core/check.h"

namespace roseau::synthesis {

namespace {
constexpr double kStepS = 1.0 / 256;  // a power of two: grid times are exact, and 4 steps lie between two wind table entries
constexpr double kForgottenAfterTimeConstants = 20;  // e^-20: what is left of the start at time 0

double grid_time_s(std::int64_t step) { return static_cast<double>(step) * kStepS; }

double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
}  // namespace

BranchMotion::BranchMotion(const BranchMotionOptions& options, double mean_speed_mps, std::shared_ptr<const WindField> wind)
    : options_(options),
      wind_(std::move(wind)),
      oscillator_(options.natural_frequency_hz, options.damping_ratio),
      drag_gain_(std::pow(oscillator_.angular_frequency_rad_s(), 2) * options.mean_deflection_m /
                 std::pow(mean_speed_mps, options.drag_exponent)) {
  ROSEAU_CHECK(options.damping_ratio > 0 && mean_speed_mps > 0);
  const double time_constant_s = 2 / oscillator_.damping_coefficient_per_s();
  first_step_ = -std::llround(std::ceil(kForgottenAfterTimeConstants * time_constant_s / kStepS));
  restart();
}

void BranchMotion::restart() {
  step_ = first_step_;
  state_ = {};
  force_ = force_per_mass_mps2(grid_time_s(step_));
  next_force_ = force_per_mass_mps2(grid_time_s(step_ + 1));
  state_.position = force_ / std::pow(oscillator_.angular_frequency_rad_s(), 2);
}

double BranchMotion::wind_along_axis_mps(double time_s) const {
  return dot(wind_->velocity_mps(options_.drag_point_in_world, time_s), options_.axis_in_world);
}

double BranchMotion::force_per_mass_mps2(double time_s) const {
  const Vec3 wind = wind_->velocity_mps(options_.drag_point_in_world, time_s);
  const double speed_mps = std::sqrt(dot(wind, wind));
  if (speed_mps == 0) return 0;
  return drag_gain_ * std::pow(speed_mps, options_.drag_exponent - 1) * dot(wind, options_.axis_in_world);
}

double BranchMotion::deflection_m(double time_s) {
  const auto wanted = static_cast<std::int64_t>(std::floor(time_s / kStepS));
  if (wanted < step_) restart();
  for (; step_ < wanted; ++step_) {
    state_ = oscillator_.step(state_, force_, next_force_, kStepS);
    force_ = next_force_;
    next_force_ = force_per_mass_mps2(grid_time_s(step_ + 2));
  }
  const double into_step_s = time_s - grid_time_s(step_);
  const double force_now = force_ + (next_force_ - force_) * into_step_s / kStepS;
  return oscillator_.step(state_, force_, force_now, into_step_s).position;
}

}  // namespace roseau::synthesis
