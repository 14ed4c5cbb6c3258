// A branch pulled with a rope (thesis 2.3.3): how the whole tree bends, and how much of that its modes can show.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "core/geometry.h"
#include "core/result.h"
#include "structure/mechanics/beam_structure.h"
#include "structure/mechanics/modal_model.h"

namespace roseau::structure {

struct StaticPull {
  Vec3 force_n;
  Vec3 displacement_m;          // of the pulled node, from K u = F with every degree of freedom
  Eigen::VectorXd amplitudes;   // of the modes: phi^T M u
  Vec3 modal_displacement_m;    // of the pulled node, by the modes alone
  double truncation_error = 0;  // |displacement - modal displacement| over |displacement|: what the missing modes would add
  double energy_share = 0;      // of the elastic energy, in the modes
};

/// `structure` is the one that `model` was made of; the model's parameters count. Large pulls are taken as linear.
/// Error (invalid_argument): a node that does not exist or stands in the ground, or no force.
Result<StaticPull> static_pull(const BeamStructure& structure, const ModalModel& model, std::size_t node, const Vec3& force_n);

/// With the force along `direction` (of any length) that displaces the node by as much along it.
Result<StaticPull> static_pull_by(const BeamStructure& structure, const ModalModel& model, std::size_t node,
                                  const Vec3& direction, double displacement_m);

}  // namespace roseau::structure
