#include "structure/tree/tree_check.h"

#include <fmt/format.h>

#include "structure/tree/vector3.h"

namespace roseau::structure {

namespace {

constexpr double kUnitTolerance = 1e-6;
constexpr double kFootTolerance_m = 1e-6;

bool is_positive(double value) { return std::isfinite(value) && value > 0; }

const char* node_fault(const TreeModel& tree, std::size_t i) {
  const TreeNode& node = tree.nodes[i];
  if (!is_finite(node.position_m)) return "has no finite position";
  if (i == 0) {
    if (node.parent != TreeNode::kNoParent) return "is the first and yet has a parent";
    return norm(node.position_m) <= kFootTolerance_m ? nullptr : "is the foot and yet not at the origin";
  }
  if (node.parent == TreeNode::kNoParent) return "hangs on no other: the tree is in pieces";
  if (node.parent < 0 || static_cast<std::size_t>(node.parent) >= i) return "does not come after its parent";
  if (!is_positive(node.start_radius_m) || !is_positive(node.end_radius_m)) return "has no positive radius";
  const Vec3& from = tree.nodes[static_cast<std::size_t>(node.parent)].position_m;
  return is_positive(distance(from, node.position_m)) ? nullptr : "has a segment of no length";
}

const char* leaf_fault(const TreeModel& tree, const Leaf& leaf) {
  if (leaf.node >= tree.nodes.size()) return "hangs on a node that does not exist";
  if (!is_finite(leaf.base_m)) return "has no finite position";
  if (!is_positive(leaf.length_m) || !is_positive(leaf.width_m)) return "has no positive size";
  if (!is_finite(leaf.direction) || !is_finite(leaf.normal)) return "has no finite direction";
  if (std::abs(norm(leaf.direction) - 1) > kUnitTolerance || std::abs(norm(leaf.normal) - 1) > kUnitTolerance) {
    return "has a direction or normal that is no unit vector";
  }
  return std::abs(dot(leaf.direction, leaf.normal)) <= kUnitTolerance ? nullptr : "has a normal that leans along its blade";
}

}  // namespace

Result<void> check(const TreeModel& tree) {
  const auto broken = [&tree](const std::string& what) { return Error{ErrorCode::corrupt, tree.name + ": " + what}; };
  if (tree.nodes.size() < 2) return broken("a tree needs at least one segment, that is two nodes");
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    if (const char* fault = node_fault(tree, i)) return broken(fmt::format("node {} {}", i, fault));
  }
  for (std::size_t i = 0; i < tree.leaves.size(); ++i) {
    if (const char* fault = leaf_fault(tree, tree.leaves[i])) return broken(fmt::format("leaf {} {}", i, fault));
  }
  return {};
}

}  // namespace roseau::structure
