// TreeModel: a tree's shape at rest, as a chain of straight pieces of wood (segments) and the leaves on them. Comes from a
// digitised tree (mtg.h), from cylinders fitted to a laser scan (qsm.h) or from a seed (grown_tree.h).
//
// Tree frame: metres, origin at the foot of the trunk, z up; x and y as the world's (x east, y north) unless the tree is placed
// with a rotation.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry.h"

namespace roseau::structure {

/// A point of the skeleton. Every node but the first stands at the upper end of one segment, that begins at its parent.
struct TreeNode {
  static constexpr std::int32_t kNoParent = -1;

  Vec3 position_m;
  std::int32_t parent = kNoParent;  // index of an earlier node; kNoParent for the first node only, which stands in the ground
  double start_radius_m = 0;        // of the segment's wood at the parent's end
  double end_radius_m = 0;          // and at this node
  std::uint16_t order = 0;          // 0: trunk, 1: branches on it, ...
};

/// A flat leaf, fixed to its node: it moves and turns with it.
struct Leaf {
  std::uint32_t node = 0;
  Vec3 base_m;     // where its blade begins, at rest
  Vec3 direction;  // unit vector along the blade, from the base to the tip
  Vec3 normal;     // unit vector, the upper side
  double length_m = 0;
  double width_m = 0;
};

struct TreeModel {
  std::string name;
  std::vector<TreeNode> nodes;  // parents before children; nodes[0] is the foot
  std::vector<Leaf> leaves;

  std::size_t segment_count() const { return nodes.empty() ? 0 : nodes.size() - 1; }
};

}  // namespace roseau::structure
