// BeamStructure: the stiffness and mass matrices of a whole tree (thesis 6.2.1), clamped in the ground at its first node.
#pragma once

#include <Eigen/SparseCore>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/result.h"
#include "structure/tree/tree_model.h"

namespace roseau::structure {

/// Green wood and foliage. Defaults: the thesis's; leaf mass per area of fresh broad leaves.
struct Material {
  double young_modulus_pa = 1e10;
  double poisson_ratio = 0.3;  // shear modulus G = E / (2 (1 + ratio))
  double density_kg_m3 = 1000;
  double leaf_mass_per_area_kg_m2 = 0.2;
};

/// Something small that is fixed to a node: a marker ball, a load of leaves that the model does not list one by one.
struct PointMass {
  std::uint32_t node = 0;
  double mass_kg = 0;
};

struct BeamOptions {
  Material material;
  std::vector<PointMass> point_masses;
};

/// One side of all leaves of each node.
std::vector<double> leaf_area_by_node_m2(const TreeModel& tree);

/// M u'' + K u = f in the tree's frame. Both matrices are symmetric and stored whole. Node n > 0 has six degrees of freedom in
/// a row, displacement (x, y, z) in metres then rotation vector (x, y, z) in radians; the first node is clamped and has none.
///
/// Nodes are numbered from the last to the first: eliminated in that order, a tree's children before their parent, the
/// factorisation of K fills in nothing beside what K already holds.
struct BeamStructure {
  static constexpr Eigen::Index kDofPerNode = 6;

  std::size_t node_count = 0;
  Eigen::SparseMatrix<double> stiffness;
  Eigen::SparseMatrix<double> mass;
  double wood_mass_kg = 0;
  double leaf_mass_kg = 0;
  double point_mass_kg = 0;

  Eigen::Index dof_count() const { return stiffness.rows(); }
  /// Of the node's displacement in x; its five other degrees of freedom follow. Not for the clamped node 0.
  Eigen::Index first_dof(std::size_t node) const { return static_cast<Eigen::Index>(node_count - 1 - node) * kDofPerNode; }
  double total_mass_kg() const { return wood_mass_kg + leaf_mass_kg + point_mass_kg; }
};

/// Error (corrupt): the tree breaks a rule of tree_check.h. Error (invalid_argument): a material that is none, a point mass
/// below zero or on a node that does not exist.
Result<BeamStructure> assemble_beams(const TreeModel& tree, const BeamOptions& options);

}  // namespace roseau::structure
