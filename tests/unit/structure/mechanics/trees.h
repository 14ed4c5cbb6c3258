// Trees whose modes have closed forms.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <vector>

#include "structure/mechanics/beam_structure.h"
#include "structure/tree/cantilever.h"
#include "structure/tree/tree_model.h"

namespace roseau::testing {

inline structure::TreeModel pole(std::size_t segments, double length_m = 2, double radius_m = 0.02) {
  auto tree = structure::cantilever(
      {.length_m = length_m, .start_radius_m = radius_m, .end_radius_m = radius_m, .segment_count = segments});
  ROSEAU_CHECK(tree.has_value());
  return *tree;
}

/// Adds a straight branch of some segments; its last node.
inline std::size_t add_branch(structure::TreeModel& tree, std::size_t from, const Vec3& along_m, double start_radius_m,
                              double end_radius_m, std::size_t segments) {
  const Vec3 start = tree.nodes[from].position_m;
  std::size_t parent = from;
  for (std::size_t i = 1; i <= segments; ++i) {
    const double before = static_cast<double>(i - 1) / static_cast<double>(segments);
    const double share = static_cast<double>(i) / static_cast<double>(segments);
    tree.nodes.push_back({.position_m = {start.x + share * along_m.x, start.y + share * along_m.y, start.z + share * along_m.z},
                          .parent = static_cast<std::int32_t>(parent),
                          .start_radius_m = start_radius_m + before * (end_radius_m - start_radius_m),
                          .end_radius_m = start_radius_m + share * (end_radius_m - start_radius_m)});
    parent = tree.nodes.size() - 1;
  }
  return parent;
}

inline structure::TreeModel turned(structure::TreeModel tree, const Eigen::Matrix3d& rotation) {
  const auto turn = [&](Vec3& v) {
    const Eigen::Vector3d r = rotation * Eigen::Vector3d(v.x, v.y, v.z);
    v = {r.x(), r.y(), r.z()};
  };
  for (auto& node : tree.nodes) turn(node.position_m);
  for (auto& leaf : tree.leaves) {
    turn(leaf.base_m);
    turn(leaf.direction);
    turn(leaf.normal);
  }
  return tree;
}

inline structure::Leaf leaf_at(std::size_t node, const Vec3& position, double length_m, double width_m) {
  return {.node = static_cast<std::uint32_t>(node),
          .base_m = position,
          .direction = {1, 0, 0},
          .normal = {0, 0, 1},
          .length_m = length_m,
          .width_m = width_m};
}

/// A small tree without any symmetry: a bent trunk, branches on branches, leaves.
inline structure::TreeModel crooked_tree() {
  structure::TreeModel tree{.name = "crooked", .nodes = {structure::TreeNode{}}};
  const std::size_t fork = add_branch(tree, 0, {0.1, -0.05, 1.5}, 0.03, 0.022, 4);
  const std::size_t top = add_branch(tree, fork, {-0.2, 0.15, 1.2}, 0.018, 0.006, 4);
  const std::size_t left = add_branch(tree, fork, {0.9, 0.2, 0.6}, 0.015, 0.005, 4);
  const std::size_t twig = add_branch(tree, left - 2, {0.1, 0.5, 0.1}, 0.006, 0.003, 3);
  for (const std::size_t node : {top, left, twig, top - 1}) {
    tree.leaves.push_back(leaf_at(node, tree.nodes[node].position_m, 0.12, 0.08));
    tree.leaves.push_back(leaf_at(node, tree.nodes[node].position_m, 0.10, 0.06));
  }
  return tree;
}

}  // namespace roseau::testing
