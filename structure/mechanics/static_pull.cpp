#include "structure/mechanics/static_pull.h"

#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <cmath>

#include "structure/tree/vector3.h"

namespace roseau::structure {
namespace {

Vec3 vec3_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Result<void> check_pull(const BeamStructure& structure, std::size_t node, const Vec3& direction) {
  if (node == 0 || node >= structure.node_count) {
    return Error{ErrorCode::invalid_argument,
                 fmt::format("node {} cannot be pulled: those that can move are 1 to {}", node, structure.node_count - 1)};
  }
  if (!is_finite(direction) || norm(direction) == 0) {
    return Error{ErrorCode::invalid_argument, "a pull needs a direction and a force above zero"};
  }
  return {};
}

/// Displacements of the whole structure under a force at one node.
Eigen::VectorXd bend(const BeamStructure& structure, std::size_t node, const Vec3& force_n) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(structure.dof_count());
  force.segment<3>(structure.first_dof(node)) = Eigen::Vector3d(force_n.x, force_n.y, force_n.z);
  // Numbered so that nothing fills in, see BeamStructure.
  using Factorisation = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>>;
  return Factorisation(structure.stiffness).solve(force);
}

}  // namespace

Result<StaticPull> static_pull(const BeamStructure& structure, const ModalModel& model, std::size_t node, const Vec3& force_n) {
  ROSEAU_CHECK(structure.node_count == model.node_count());
  if (auto checked = check_pull(structure, node, force_n); !checked) return checked.error();
  const Eigen::VectorXd bent = bend(structure, node, force_n) / model.parameters().young_modulus_scale;
  const Eigen::VectorXd modal_force = model.modal_force_at(node, force_n);
  StaticPull pull{.force_n = force_n,
                  .displacement_m = vec3_of(bent.segment<3>(structure.first_dof(node))),
                  .amplitudes = model.static_amplitudes(modal_force)};
  pull.modal_displacement_m = model.displacement_m(node, pull.amplitudes);
  pull.truncation_error = distance(pull.displacement_m, pull.modal_displacement_m) / norm(pull.displacement_m);
  // Both energies are half the work of the force.
  pull.energy_share = dot(force_n, pull.modal_displacement_m) / dot(force_n, pull.displacement_m);
  return pull;
}

Result<StaticPull> static_pull_by(const BeamStructure& structure, const ModalModel& model, std::size_t node,
                                  const Vec3& direction, double displacement_m) {
  if (!(std::isfinite(displacement_m) && displacement_m > 0)) {
    return Error{ErrorCode::invalid_argument, fmt::format("a branch cannot be pulled by {} m", displacement_m)};
  }
  if (auto checked = check_pull(structure, node, direction); !checked) return checked.error();
  const Vec3 along = unit(direction);
  const auto by_one_newton = static_pull(structure, model, node, along);
  if (!by_one_newton) return by_one_newton.error();
  return static_pull(structure, model, node, (displacement_m / dot(along, by_one_newton->displacement_m)) * along);
}

}  // namespace roseau::structure
