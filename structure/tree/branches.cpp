#include "structure/tree/branches.h"

#include <algorithm>

#include "core/check.h"
#include "structure/tree/statistics.h"
#include "structure/tree/vector3.h"

namespace roseau::structure {

namespace {

double length_m(const TreeModel& tree, const TreeNode& node) {
  return distance(node.position_m, tree.nodes[static_cast<std::size_t>(node.parent)].position_m);
}

}  // namespace

std::vector<Branch> main_branches(const TreeModel& tree) {
  constexpr std::size_t kTrunk = static_cast<std::size_t>(-1);
  std::vector<Branch> branches;
  std::vector<std::size_t> branch_of(tree.nodes.size(), kTrunk);
  std::vector<double> reach_m(tree.nodes.size(), 0.0);
  for (std::uint32_t i = 1; i < tree.nodes.size(); ++i) {
    const TreeNode& node = tree.nodes[i];
    const auto parent = static_cast<std::size_t>(node.parent);
    branch_of[i] = branch_of[parent];
    if (branch_of[i] == kTrunk) {
      if (node.order == 0) continue;
      branch_of[i] = branches.size();
      branches.push_back({.first = i, .tip = i});
    }
    Branch& branch = branches[branch_of[i]];
    reach_m[i] = reach_m[parent] + length_m(tree, node);
    ++branch.segments;
    branch.wood_m3 += wood_volume_m3(length_m(tree, node), node.start_radius_m, node.end_radius_m);
    if (reach_m[i] > branch.reach_m) {
      branch.reach_m = reach_m[i];
      branch.tip = i;
    }
  }
  for (const Leaf& leaf : tree.leaves) {
    if (branch_of[leaf.node] != kTrunk) branches[branch_of[leaf.node]].leaf_area_m2 += area_m2(leaf);
  }
  std::stable_sort(branches.begin(), branches.end(), [](const Branch& a, const Branch& b) { return a.wood_m3 > b.wood_m3; });
  return branches;
}

std::uint32_t node_along(const TreeModel& tree, const Branch& branch, double share) {
  double left_m = (1 - share) * branch.reach_m;
  std::uint32_t node = branch.tip;
  while (node != branch.first) {
    if (left_m <= 1e-9 * branch.reach_m) break;
    left_m -= length_m(tree, tree.nodes[node]);
    node = static_cast<std::uint32_t>(tree.nodes[node].parent);
  }
  return node;
}

std::uint32_t nearest_node(const TreeModel& tree, const Vec3& point_m) {
  ROSEAU_CHECK(!tree.nodes.empty());
  const auto nearest = std::min_element(tree.nodes.begin(), tree.nodes.end(), [&](const TreeNode& a, const TreeNode& b) {
    return distance(a.position_m, point_m) < distance(b.position_m, point_m);
  });
  return static_cast<std::uint32_t>(nearest - tree.nodes.begin());
}

std::vector<std::uint32_t> path_to_foot(const TreeModel& tree, std::uint32_t node) {
  ROSEAU_CHECK(node < tree.nodes.size());
  std::vector<std::uint32_t> path{node};
  while (tree.nodes[path.back()].parent != TreeNode::kNoParent) {
    path.push_back(static_cast<std::uint32_t>(tree.nodes[path.back()].parent));
  }
  return path;
}

std::vector<std::uint32_t> subtree(const TreeModel& tree, std::uint32_t node) {
  ROSEAU_CHECK(node < tree.nodes.size());
  std::vector<bool> inside(tree.nodes.size(), false);
  std::vector<std::uint32_t> found{node};
  inside[node] = true;
  for (std::uint32_t i = node + 1; i < tree.nodes.size(); ++i) {
    inside[i] = inside[static_cast<std::size_t>(tree.nodes[i].parent)];
    if (inside[i]) found.push_back(i);
  }
  return found;
}

std::vector<std::vector<std::uint32_t>> children(const TreeModel& tree) {
  std::vector<std::vector<std::uint32_t>> all(tree.nodes.size());
  for (std::uint32_t i = 1; i < tree.nodes.size(); ++i) all[static_cast<std::size_t>(tree.nodes[i].parent)].push_back(i);
  return all;
}

}  // namespace roseau::structure
