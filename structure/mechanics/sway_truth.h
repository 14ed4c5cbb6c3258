// What someone who watches one point of a swaying tree should find: which mode he sees, its natural frequency and its damping
// in the wind, and where the point would stand if the force of the moment acted for ever.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/geometry.h"
#include "structure/mechanics/modal_model.h"

namespace roseau::structure {

struct DominantMode {
  std::size_t mode = 0;
  double share = 0;  // of all modes' contributions, each taken without its sign
};

/// The mode that moves a node most along a direction under the modal force given (of the wind: WindProjection::modal_force; of
/// a rope: ModalModel::modal_force_at), slowly applied: |phi_i(node) . direction f_i| / w_i^2. Under turbulence, whose power
/// falls with frequency, and after a release it is the same one unless two are close.
DominantMode dominant_mode(const ModalModel& model, std::size_t node, const Vec3& direction,
                           const Eigen::VectorXd& modal_force);

struct LinearisedMode {
  double natural_frequency_hz = 0;  // |s| / 2 pi of the pair of eigenvalues s: what a damped oscillator's equation has for w
  double damping_ratio = 0;         // -Re s / |s|: structure and air together
};

/// The tree's modes in a steady wind: roots of det(s^2 m + s (m gamma + C) + m w^2) = 0 with the full aerodynamic damping
/// matrix C of DragLoad::damping_matrix(), which also couples modes. Entry i is the one most like mode i in still air. In
/// turbulent wind the damping is a little higher, for the mean speed's power n - 1 is less than the mean of that power.
std::vector<LinearisedMode> linearised_modes(const ModalModel& model, const Eigen::MatrixXd& aerodynamic_damping);

/// Displacement of a node if the modal forces stayed as they are: the input of the sway, as an estimator of force sees it.
Vec3 equivalent_static_displacement_m(const ModalModel& model, std::size_t node, const Eigen::VectorXd& modal_force);

}  // namespace roseau::structure
