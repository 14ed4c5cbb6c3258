#include "tracking/placement.h"

#include <Eigen/LU>

namespace roseau::tracking {

Eigen::Matrix2d Placement::warp() const { return Eigen::Matrix2d::Identity() + motion.gradient + camera.motion.gradient; }

Eigen::Vector2d Placement::expected(const Eigen::Vector2d& reference) const {
  return reference + camera.at(reference) + motion.at(reference - centre);
}

Eigen::Vector2d Placement::reference_of(const Eigen::Vector2d& position) const {
  // expected(r) = r + Dc + Gc (r - cc) + D + G (r - c), linear in r.
  const Eigen::Vector2d constant =
      camera.motion.displacement - camera.motion.gradient * camera.centre + motion.displacement - motion.gradient * centre;
  return warp().inverse() * (position - constant);
}

}  // namespace roseau::tracking
