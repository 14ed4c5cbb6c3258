// Radii that a source does not give.
#pragma once

#include <cstddef>

#include "structure/tree/tree_model.h"

namespace roseau::structure {

struct RadiusRepair {
  std::size_t from_branches = 0;  // ends whose radius follows from what they bear
  std::size_t tips = 0;           // ends that bear nothing
};

/// Fills in the radii that are NaN. At an end: the pipe model (cross-section = sum of those borne), `tip_radius_m` where
/// nothing is borne, never thicker than the bearer's end where that is known. At a start: a segment that goes on in the order
/// of its bearer begins with that one's radius, a branch is a cylinder.
RadiusRepair fill_missing_radii(TreeModel& tree, double tip_radius_m);

}  // namespace roseau::structure
