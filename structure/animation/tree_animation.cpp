#include "structure/animation/tree_animation.h"

#include <cmath>

#include "structure/mechanics/wind_projection.h"

namespace roseau::structure {

Skeleton skeleton(const TreeModel& tree) {
  Skeleton skeleton{.rest_m = Eigen::VectorXd(static_cast<Eigen::Index>(3 * tree.nodes.size())), .parents = {}};
  Eigen::Index at = 0;
  for (const TreeNode& node : tree.nodes) {
    skeleton.rest_m.segment<3>(at) << node.position_m.x, node.position_m.y, node.position_m.z;
    skeleton.parents.push_back(node.parent);
    at += 3;
  }
  return skeleton;
}

Result<ModalBasis> modal_basis(const ModalModel& model, const DragLoad& load, const Vec3& mean_wind_mps) {
  ROSEAU_CHECK(load.mode_count() == model.mode_count());
  const double speed_mps = std::hypot(mean_wind_mps.x, mean_wind_mps.y, mean_wind_mps.z);
  const auto modes = static_cast<Eigen::Index>(model.mode_count());
  ModalBasis basis{.shapes = model.translations(),
                   .natural_frequency_hz = Eigen::VectorXd(modes),
                   .damping_coefficient_per_s = model.damping_coefficient_per_s(),
                   .wind_projection = Eigen::Matrix3Xd::Zero(3, modes)};
  for (std::size_t i = 0; i < model.mode_count(); ++i) {
    basis.natural_frequency_hz[static_cast<Eigen::Index>(i)] = model.natural_frequency_hz(i);
  }
  for (const DragLoad::Part& part : {load.wood(), load.foliage()}) {
    if (part.exponent != 2 && !(speed_mps > 0)) {
      return Error{ErrorCode::invalid_argument,
                   "modal basis: a tree with a Vogel exponent needs the wind it will mostly stand in; give a mean wind that is "
                   "not zero"};
    }
    const double factor = part.exponent == 2 ? 1 : std::pow(speed_mps, part.exponent - 2);
    basis.wind_projection += factor / model.modal_mass() * part.push;
  }
  basis.damping_coefficient_per_s += (WindProjection(load).damping(mean_wind_mps) / model.modal_mass()).matrix();
  return basis;
}

}  // namespace roseau::structure
