#include "structure/mechanics/beam_structure.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <optional>

#include "structure/mechanics/beam_element.h"

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

std::optional<Error> complaint(const TreeModel& tree, std::size_t index) {
  const TreeNode& node = tree.nodes[index];
  const auto parent = static_cast<std::size_t>(node.parent);
  if (node.parent < 0 || parent >= index) return invalid(fmt::format("node {}: its parent must come before it", index));
  const double length = (vector_of(node.position_m) - vector_of(tree.nodes[parent].position_m)).norm();
  if (!is_positive(length)) return invalid(fmt::format("node {}: its segment has no length ({} m)", index, length));
  if (!is_not_below_zero(node.start_radius_m) || !is_not_below_zero(node.end_radius_m) ||
      !is_positive(node.start_radius_m + node.end_radius_m)) {
    return invalid(fmt::format("node {}: its segment has no thickness (radius {} m to {} m)", index, node.start_radius_m,
                               node.end_radius_m));
  }
  return std::nullopt;
}

std::optional<Error> complaint(const TreeModel& tree, const BeamOptions& options) {
  if (tree.nodes.size() < 2) {
    return invalid(fmt::format("tree \"{}\" has {} node(s); it needs at least two to bend", tree.name, tree.nodes.size()));
  }
  if (auto error = complaint(options.material)) return error;
  for (std::size_t i = 1; i < tree.nodes.size(); ++i) {
    if (tree.nodes[i].parent == TreeNode::kNoParent) continue;
    if (auto error = complaint(tree, i)) return error;
  }
  for (const Leaf& leaf : tree.leaves) {
    if (leaf.node >= tree.nodes.size()) return invalid(fmt::format("a leaf on node {}, which does not exist", leaf.node));
    if (!is_not_below_zero(leaf.length_m) || !is_not_below_zero(leaf.width_m)) {
      return invalid(fmt::format("a leaf on node {} without a size", leaf.node));
    }
  }
  for (const PointMass& mass : options.point_masses) {
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
    const double a = beam.start_radius_m;
    const double b = beam.end_radius_m;
    structure_.wood_mass_kg += beam.density_kg_m3 * std::numbers::pi * beam.length_m * (a * a + a * b + b * b) / 3;
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

double leaf_area_m2(const Leaf& leaf) { return std::numbers::pi / 4 * leaf.length_m * leaf.width_m; }

std::vector<double> leaf_area_by_node_m2(const TreeModel& tree) {
  std::vector<double> area(tree.nodes.size(), 0.0);
  for (const Leaf& leaf : tree.leaves) area.at(leaf.node) += leaf_area_m2(leaf);
  return area;
}

Result<BeamStructure> assemble_beams(const TreeModel& tree, const BeamOptions& options) {
  if (auto error = complaint(tree, options)) return *std::move(error);
  Assembler assembler(tree, options);
  for (std::size_t i = 1; i < tree.nodes.size(); ++i) {
    if (tree.nodes[i].parent != TreeNode::kNoParent) assembler.add_segment(i);
  }
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
