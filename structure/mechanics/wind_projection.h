// The wind projection basis (thesis 6.29, 6.30): under a wind that is the same all over the tree, the modal forces are
//
//   f_i = |v|^(n - 1) v . p_i        p_i = integral of 1/2 rho C_D D phi_i dp
//
// with one precomputed vector per mode, whatever the tree's size; with streamlining of the leaves, one for the wood and one for
// the leaves. What is left out, beside gusts within the crown, is the tree's own motion: compensated by the aerodynamic damping
// below, added to the modes' own.
#pragma once

#include <Eigen/Core>
#include <span>

#include "core/wind_field.h"
#include "structure/mechanics/drag_load.h"

namespace roseau::structure {

class WindProjection {
 public:
  explicit WindProjection(const DragLoad& load);

  /// Modal forces; `force` gets one value per mode. No allocation.
  void modal_force(const Vec3& air_mps, Eigen::VectorXd& force) const;

  /// What the relative velocity adds to each mode's damping coefficient in a steady wind, times the modal mass: the diagonal of
  /// DragLoad::damping_matrix(). In gusty wind take the mean: the damping follows the speed to the power n - 1.
  Eigen::ArrayXd damping(const Vec3& mean_air_mps) const;

  /// Where the one wind is to be taken: the mean of the points, each weighted with its drag.
  const Vec3& centre_in_world() const { return centre_in_world_; }

 private:
  DragLoad::Part wood_;
  DragLoad::Part foliage_;
  bool relative_velocity_;
  Vec3 centre_in_world_;
};

/// How far the projection is from the full integration.
struct ProjectionError {
  double relative_rms = 0;       // RMS of the difference over RMS of the full modal forces, all modes together
  Eigen::ArrayXd rms;            // per mode: RMS of the difference
  Eigen::ArrayXd reference_rms;  // per mode: RMS of the full integration
};

/// Both at the given times in a wind, the tree at rest; the projection takes the wind at its centre.
ProjectionError compare_projection(DragLoad& load, const WindField& wind, std::span<const double> times_s);

}  // namespace roseau::structure
