// A tree grown from a seed: broad-leaved, like a young walnut or oak. The same options and seed give the same bits.
//
// The trunk rises to the full height; main branches leave it by the golden angle and grow, as do the branches on them, until
// they leave a rounded, slightly irregular crown. Radii follow the pipe model: at every fork the cross-section below equals
// the sum of those above (da Vinci's rule); along a segment it grows by what its own leaves need, and by 12 % per metre (of a
// tree of 5.5 m) for twigs shed long ago.
#pragma once

#include <cstdint>

#include "core/result.h"
#include "structure/tree/tree_model.h"

namespace roseau::structure {

/// The limits stand beside each: 0.5 .. 40 means from 0.5 to 40.
struct GrownTreeOptions {
  std::uint64_t seed = 1;
  double height_m = 5.5;                 // 0.5 .. 40, of the topmost node
  double trunk_radius_m = 0.07;          // at the foot; height / 500 .. height / 5
  double crown_base_m = 1.45;            // lowest main branch; 0 .. 0.8 height
  double crown_width_m = 4.2;            // 0.1 .. 2 height
  std::uint32_t main_branch_count = 18;  // 1 .. 200
  std::uint32_t branching_orders = 3;    // 1: main branches only; 2: branches on them, too; .. 4
  std::uint32_t leaf_count = 4000;       // 0 .. 500000, exact
  double leaf_length_m = 0.095;          // mean; single leaves differ by up to a quarter; 0.005 .. 1
  double leaf_width_m = 0.06;            // 0.005 .. 1
};

/// Error (invalid_argument): the option that is out of its limits.
Result<TreeModel> grow_tree(const GrownTreeOptions& options);

}  // namespace roseau::structure
