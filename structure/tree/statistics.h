// Figures of a tree, for people and for plausibility checks.
#pragma once

#include <cstdint>
#include <vector>

#include "structure/tree/tree_model.h"

namespace roseau::structure {

/// Of a broad leaf's blade, taken for an ellipse with the leaf's length and width.
double area_m2(const Leaf& leaf);

/// Wood between a segment's two radii, a cone's frustum.
double wood_volume_m3(double length_m, double start_radius_m, double end_radius_m);

struct TreeStatistics {
  struct Order {
    std::size_t axes = 0;  // trunk, branches: runs of segments of this order
    std::size_t segments = 0;
    double length_m = 0;
    double wood_m3 = 0;
  };

  std::size_t nodes = 0;
  std::size_t segments = 0;
  std::size_t tips = 0;
  double height_m = 0;       // of the highest node above the foot
  double lowest_m = 0;       // of the lowest node: below zero for a branch that hangs lower than the foot
  double extent_east_m = 0;  // of all nodes
  double extent_north_m = 0;
  double wood_length_m = 0;
  double wood_m3 = 0;
  double foot_radius_m = 0;
  double radius_at_1_3_m = 0;  // of the order-0 axis at breast height; 0 for a lower tree
  double thinnest_radius_m = 0;
  std::size_t leaves = 0;
  double leaf_area_m2 = 0;  // one side
  std::vector<Order> orders;
};

TreeStatistics statistics(const TreeModel& tree);

}  // namespace roseau::structure
