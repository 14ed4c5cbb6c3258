// Finding one's way in a tree: its branches, from the largest to the smallest, and the nodes on them.
#pragma once

#include <cstdint>
#include <vector>

#include "structure/tree/tree_model.h"

namespace roseau::structure {

/// What hangs on one node of the trunk: everything above one segment of order above 0 that begins there.
struct Branch {
  std::uint32_t first = 0;  // the upper node of the branch's lowest segment; its parent is the trunk's node
  std::uint32_t tip = 0;    // the end farthest from the trunk, along the wood
  std::size_t segments = 0;
  double reach_m = 0;  // along the wood, from the trunk to the tip
  double wood_m3 = 0;
  double leaf_area_m2 = 0;
};

/// The branches on the trunk, most wood first; those with equal wood in the order of their nodes. Empty for a bare pole.
std::vector<Branch> main_branches(const TreeModel& tree);

/// The node `share` (0 .. 1) of the way from the trunk to the branch's tip, along the wood: the last one not beyond it, but
/// never the trunk's. This is where a marker ball or a target goes.
std::uint32_t node_along(const TreeModel& tree, const Branch& branch, double share);

/// The node nearest to a point of the tree's frame (the lowest index of equally near ones). CHECKs that there is a node.
std::uint32_t nearest_node(const TreeModel& tree, const Vec3& point_m);

/// From the node down to the foot, both included.
std::vector<std::uint32_t> path_to_foot(const TreeModel& tree, std::uint32_t node);

/// The node and everything it bears, parents first.
std::vector<std::uint32_t> subtree(const TreeModel& tree, std::uint32_t node);

/// For each node, those that stand on it.
std::vector<std::vector<std::uint32_t>> children(const TreeModel& tree);

}  // namespace roseau::structure
