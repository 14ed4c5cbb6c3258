#include "structure/mechanics/wind_projection.h"

#include <cmath>

#include "structure/tree/vector3.h"

namespace roseau::structure {

WindProjection::WindProjection(const DragLoad& load)
    : wood_(load.wood()), foliage_(load.foliage()), relative_velocity_(load.has_relative_velocity()) {
  const double weight = wood_.weight + foliage_.weight;
  if (weight > 0) {
    centre_in_world_ = (wood_.weight / weight) * wood_.centre_in_world + (foliage_.weight / weight) * foliage_.centre_in_world;
  }
}

void WindProjection::modal_force(const Vec3& air_mps, Eigen::VectorXd& force) const {
  const Eigen::Vector3d air(air_mps.x, air_mps.y, air_mps.z);
  const double speed = air.norm();
  force.setZero(wood_.push.cols());
  if (speed == 0) return;
  force.noalias() += wood_.push.transpose() * (std::pow(speed, wood_.exponent - 1) * air);
  force.noalias() += foliage_.push.transpose() * (std::pow(speed, foliage_.exponent - 1) * air);
}

Eigen::ArrayXd WindProjection::damping(const Vec3& mean_air_mps) const {
  Eigen::ArrayXd damping = Eigen::ArrayXd::Zero(wood_.damping.cols());
  if (!relative_velocity_) return damping;
  for (const DragLoad::Part* part : {&wood_, &foliage_}) {
    const Eigen::Matrix3d slope = drag_slope(mean_air_mps, part->exponent);
    damping += (part->damping.transpose() * slope.reshaped()).array();
  }
  return damping;
}

ProjectionError compare_projection(DragLoad& load, const WindField& wind, std::span<const double> times_s) {
  const WindProjection projection(load);
  const auto modes = static_cast<Eigen::Index>(load.mode_count());
  const Eigen::VectorXd at_rest = Eigen::VectorXd::Zero(modes);
  Eigen::VectorXd full;
  Eigen::VectorXd projected;
  std::vector<Vec3> air_mps(load.points_in_world().size());
  ProjectionError error{.rms = Eigen::ArrayXd::Zero(modes), .reference_rms = Eigen::ArrayXd::Zero(modes)};
  for (const double time_s : times_s) {
    wind.velocities_mps(load.points_in_world(), time_s, air_mps);
    load.modal_force(air_mps, at_rest, full);
    projection.modal_force(wind.velocity_mps(projection.centre_in_world(), time_s), projected);
    error.rms += (projected - full).array().square();
    error.reference_rms += full.array().square();
  }
  const double reference = error.reference_rms.sum();
  error.relative_rms = reference > 0 ? std::sqrt(error.rms.sum() / reference) : 0;
  const double count = std::max<double>(1, static_cast<double>(times_s.size()));
  error.rms = (error.rms / count).sqrt();
  error.reference_rms = (error.reference_rms / count).sqrt();
  return error;
}

}  // namespace roseau::structure
