#include "structure/mechanics/beam_structure.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "structure/mechanics/beam_element.h"
#include "structure/tree/statistics.h"
#include "structure/tree/tree_check.h"

namespace roseau::structure {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

Eigen::Vector3d vector_of(const Vec3& v) { return {v.x, v.y, v.z}; }

Error invalid(std::string message) { return {ErrorCode::invalid_argument, std::move(message)}; }

bool is_positive(double value) { return std::isfinite(value) && value > 0; }
bool is_not_below_zero(double value) { return std::isfinite(value) && value >= 0; }

std::optional<Error> complaint(const Material& material) {
  if (!is_positive(material.young_modulus_pa)) return invalid("Young's modulus must be above zero");
  if (!(material.poisson_ratio > -1 && material.poisson_ratio <= 0.5)) {
    return invalid("Poisson's ratio must lie above -1 and at most at 0.5");
  }
  if (!is_positive(material.density_kg_m3)) return invalid("the wood's density must be above zero");
  if (!is_not_below_zero(material.leaf_mass_per_area_kg_m2)) return invalid("leaf mass per area must be zero or above");
  return std::nullopt;
}

std::optional<Error> complaint(const TreeModel& tree, const std::vector<PointMass>& masses) {
  for (const PointMass& mass : masses) {
    if (mass.node >= tree.nodes.size()) return invalid(fmt::format("a mass on node {}, which does not exist", mass.node));
    if (!is_not_below_zero(mass.mass_kg)) return invalid(fmt::format("node {}: a mass of {} kg", mass.node, mass.mass_kg));
  }
  return std::nullopt;
}

/// Turns both ends' displacements and rotations into the tree's frame.
ElementMatrix in_tree_frame(const ElementMatrix& local, const Eigen::Matrix3d& axes) {
  ElementMatrix turned;
  for (Eigen::Index row = 0; row < 12; row += 3) {
    for (Eigen::Index column = 0; column < 12; column += 3) {
      turned.block<3, 3>(row, column) = axes * local.block<3, 3>(row, column) * axes.transpose();
    }
  }
  return 0.5 * (turned + turned.transpose());
}

class Assembler {
 public:
  Assembler(const TreeModel& tree, const BeamOptions& options) : tree_(tree), material_(options.material) {
    structure_.node_count = tree.nodes.size();
    const std::size_t per_matrix = 4 * 36 * tree.nodes.size();
    stiffness_.reserve(per_matrix);
    mass_.reserve(per_matrix);
  }

  void add_segment(std::size_t index) {
    const TreeNode& node = tree_.nodes[index];
    const auto parent = static_cast<std::size_t>(node.parent);
    const Eigen::Vector3d along = vector_of(node.position_m) - vector_of(tree_.nodes[parent].position_m);
    const Beam beam{.length_m = along.norm(),
                    .start_radius_m = node.start_radius_m,
                    .end_radius_m = node.end_radius_m,
                    .young_modulus_pa = material_.young_modulus_pa,
                    .shear_modulus_pa = material_.young_modulus_pa / (2 * (1 + material_.poisson_ratio)),
                    .density_kg_m3 = material_.density_kg_m3};
    const Eigen::Matrix3d axes = beam_axes(along);
    add(stiffness_, in_tree_frame(beam_stiffness(beam), axes), parent, index);
    add(mass_, in_tree_frame(beam_mass(beam), axes), parent, index);
    structure_.wood_mass_kg += beam.density_kg_m3 * wood_volume_m3(beam.length_m, beam.start_radius_m, beam.end_radius_m);
  }

  void add_lumped(std::size_t node, double mass_kg) {
    if (node == 0) return;  // stands in the ground
    const Eigen::Index first = structure_.first_dof(node);
    for (Eigen::Index axis = 0; axis < 3; ++axis) mass_.emplace_back(first + axis, first + axis, mass_kg);
  }

  BeamStructure finish(double leaf_mass_kg, double point_mass_kg) {
    const Eigen::Index size = static_cast<Eigen::Index>(structure_.node_count - 1) * BeamStructure::kDofPerNode;
    structure_.stiffness.resize(size, size);
    structure_.mass.resize(size, size);
    structure_.stiffness.setFromTriplets(stiffness_.begin(), stiffness_.end());
    structure_.mass.setFromTriplets(mass_.begin(), mass_.end());
    structure_.leaf_mass_kg = leaf_mass_kg;
    structure_.point_mass_kg = point_mass_kg;
    return std::move(structure_);
  }

 private:
  void add(Triplets& triplets, const ElementMatrix& element, std::size_t parent, std::size_t child) const {
    const std::size_t ends[] = {parent, child};
    for (Eigen::Index row = 0; row < 12; ++row) {
      const std::size_t row_node = ends[row / 6];
      if (row_node == 0) continue;
      for (Eigen::Index column = 0; column < 12; ++column) {
        const std::size_t column_node = ends[column / 6];
        if (column_node == 0) continue;
        triplets.emplace_back(structure_.first_dof(row_node) + row % 6, structure_.first_dof(column_node) + column % 6,
                              element(row, column));
      }
    }
  }

  const TreeModel& tree_;
  const Material& material_;
  BeamStructure structure_;
  Triplets stiffness_;
  Triplets mass_;
};

}  // namespace

std::vector<double> leaf_area_by_node_m2(const TreeModel& tree) {
  std::vector<double> area(tree.nodes.size(), 0.0);
  for (const Leaf& leaf : tree.leaves) area.at(leaf.node) += area_m2(leaf);
  return area;
}

Result<BeamStructure> assemble_beams(const TreeModel& tree, const BeamOptions& options) {
  if (auto checked = check(tree); !checked) return checked.error();
  if (auto error = complaint(options.material)) return *std::move(error);
  if (auto error = complaint(tree, options.point_masses)) return *std::move(error);
  Assembler assembler(tree, options);
  for (std::size_t i = 1; i < tree.nodes.size(); ++i) assembler.add_segment(i);
  double leaf_mass_kg = 0;
  const std::vector<double> leaf_area_m2 = leaf_area_by_node_m2(tree);
  for (std::size_t i = 0; i < leaf_area_m2.size(); ++i) {
    const double mass_kg = leaf_area_m2[i] * options.material.leaf_mass_per_area_kg_m2;
    leaf_mass_kg += mass_kg;
    if (mass_kg > 0) assembler.add_lumped(i, mass_kg);
  }
  double point_mass_kg = 0;
  for (const PointMass& mass : options.point_masses) {
    point_mass_kg += mass.mass_kg;
    if (mass.mass_kg > 0) assembler.add_lumped(mass.node, mass.mass_kg);
  }
  return assembler.finish(leaf_mass_kg, point_mass_kg);
}

}  // namespace roseau::structure
