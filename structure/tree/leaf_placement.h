// Where a leaf sits on its twig and how it hangs.
#pragma once

#include <cstdint>

#include "structure/tree/dice.h"
#include "structure/tree/tree_model.h"

namespace roseau::structure {

inline constexpr double kGoldenAngle_rad = 2.399963229728653;  // pi (3 - sqrt 5)

struct LeafShape {
  double length_m = 0;
  double width_m = 0;
  double stalk_m = 0;  // between the twig's surface and the blade
};

/// A leaf `along` (0 .. 1) the segment below `node` (not the foot). Leaf `index` stands a golden angle round from the one
/// before; the blade hangs a little and turns its upper side to the sky. Sizes differ by up to a quarter.
Leaf place_leaf(const TreeModel& tree, std::uint32_t node, double along, std::uint32_t index, const LeafShape& shape,
                Dice& dice);

}  // namespace roseau::structure
