// A straight pole as a tree: its modes and its deflection have closed forms, so whatever moves trees can be checked on it.
#pragma once

#include <cstdint>

#include "core/result.h"
#include "structure/tree/tree_model.h"

namespace roseau::structure {

struct CantileverOptions {
  double length_m = 2;
  double start_radius_m = 0.02;  // at the foot
  double end_radius_m = 0.02;    // at the tip; the radius goes linearly from one to the other
  std::size_t segment_count = 20;
  Vec3 direction{0, 0, 1};  // from the foot to the tip; any length

  /// A flat board of leaves fixed to the last node and centred on it: what the wind pushes, and what a camera sees. The board
  /// is `board_leaves` rows of as many leaves; none without. Its rows run along the pole as far as the normal lets them.
  std::uint32_t board_leaves = 0;
  double board_length_m = 0.3;
  double board_width_m = 0.3;
  /// 0: rows as on graph paper, which looks the same one leaf further on; up to 1: leaves turned about their middles by up to
  /// 60 degrees, longer or shorter by up to a third, their areas and middles kept. So a tracker can tell one leaf from the
  /// next.
  double board_disorder = 0;
  Vec3 board_normal{0, -1, 0};  // to the south, where the cameras stand
};

/// Error (invalid_argument): a size that is not positive, or a direction of no length.
Result<TreeModel> cantilever(const CantileverOptions& options);

}  // namespace roseau::structure
