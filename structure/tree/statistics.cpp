#include "structure/tree/statistics.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include "structure/tree/vector3.h"

namespace roseau::structure {

namespace {

constexpr double kBreastHeight_m = 1.3;

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

void measure_extents(const TreeModel& tree, TreeStatistics& figures) {
  Extent east;
  Extent north;
  Extent up;
  for (const TreeNode& node : tree.nodes) {
    east.add(node.position_m.x);
    north.add(node.position_m.y);
    up.add(node.position_m.z);
  }
  const double foot_m = tree.nodes.front().position_m.z;
  figures.height_m = up.high - foot_m;
  figures.lowest_m = up.low - foot_m;
  figures.extent_east_m = east.high - east.low;
  figures.extent_north_m = north.high - north.low;
}

/// The radius where this segment passes breast height, 0 where it does not.
double radius_at_breast_height_m(const TreeNode& from, const TreeNode& to, double foot_m) {
  const double low_m = from.position_m.z - foot_m;
  const double high_m = to.position_m.z - foot_m;
  if (to.order != 0 || low_m > kBreastHeight_m || high_m < kBreastHeight_m || high_m <= low_m) return 0;
  const double share = (kBreastHeight_m - low_m) / (high_m - low_m);
  return to.start_radius_m + share * (to.end_radius_m - to.start_radius_m);
}

}  // namespace

double area_m2(const Leaf& leaf) { return std::numbers::pi / 4 * leaf.length_m * leaf.width_m; }

double wood_volume_m3(double length_m, double start_radius_m, double end_radius_m) {
  return std::numbers::pi / 3 * length_m *
         (start_radius_m * start_radius_m + start_radius_m * end_radius_m + end_radius_m * end_radius_m);
}

TreeStatistics statistics(const TreeModel& tree) {
  TreeStatistics figures;
  figures.nodes = tree.nodes.size();
  figures.segments = tree.segment_count();
  figures.leaves = tree.leaves.size();
  for (const Leaf& leaf : tree.leaves) figures.leaf_area_m2 += area_m2(leaf);
  if (tree.nodes.empty()) return figures;
  measure_extents(tree, figures);

  std::vector<bool> bears(tree.nodes.size(), false);
  figures.thinnest_radius_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < tree.nodes.size(); ++i) {
    const TreeNode& node = tree.nodes[i];
    const auto parent = static_cast<std::size_t>(node.parent);
    const TreeNode& from = tree.nodes[parent];
    bears[parent] = true;
    if (node.order >= figures.orders.size()) figures.orders.resize(node.order + std::size_t{1});
    auto& order = figures.orders[node.order];
    const double length_m = distance(node.position_m, from.position_m);
    const double wood_m3 = wood_volume_m3(length_m, node.start_radius_m, node.end_radius_m);
    order.axes += parent == 0 || from.order != node.order ? 1 : 0;
    order.segments += 1;
    order.length_m += length_m;
    order.wood_m3 += wood_m3;
    figures.wood_length_m += length_m;
    figures.wood_m3 += wood_m3;
    figures.thinnest_radius_m = std::min({figures.thinnest_radius_m, node.start_radius_m, node.end_radius_m});
    figures.radius_at_1_3_m =
        std::max(figures.radius_at_1_3_m, radius_at_breast_height_m(from, node, tree.nodes[0].position_m.z));
    if (parent == 0) figures.foot_radius_m = std::max(figures.foot_radius_m, node.start_radius_m);
  }
  figures.tips = static_cast<std::size_t>(std::count(bears.begin(), bears.end(), false));
  return figures;
}

}  // namespace roseau::structure
