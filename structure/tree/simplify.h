// Fewer nodes for the same tree.
//
// Two steps make a tree smaller: a node between two segments of one axis is left out and they become one; a twig at the very
// end is left out and its wood goes to what bears it (spread downwards until no radius grows by more than an eighth). The
// nodes that stay keep their places, total wood volume and the leaves stay as they are; a leaf whose node went is fixed to the
// next one. What goes first is what moves the least wood the least far, by volume times distance.
#pragma once

#include <cstddef>
#include <limits>

#include "core/result.h"
#include "structure/tree/tree_model.h"

namespace roseau::structure {

struct SimplifyOptions {
  double drop_below_radius_m = 0;  // twigs thinner than this on average go first
  double merge_within_m = 0;       // nodes nearer than this to the straight line between their neighbours go next
  std::size_t node_budget = std::numeric_limits<std::size_t>::max();  // then whatever it takes; at least 2
};

struct Simplified {
  TreeModel tree;
  std::size_t merged_nodes = 0;
  std::size_t dropped_twigs = 0;
};

/// `tree` keeps the rules of tree_check.h. Error (invalid_argument): an option that makes no sense, or a budget below what the
/// tree's forks at the foot allow.
Result<Simplified> simplify(const TreeModel& tree, const SimplifyOptions& options);

}  // namespace roseau::structure
