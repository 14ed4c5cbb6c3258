#include "structure/tree/radius_repair.h"

#include <algorithm>
#include <cmath>

namespace roseau::structure {

RadiusRepair fill_missing_radii(TreeModel& tree, double tip_radius_m) {
  RadiusRepair repair;
  auto& nodes = tree.nodes;
  std::vector<double> borne(nodes.size(), 0.0);  // sum of squared radii
  std::vector<bool> filled(nodes.size(), false);
  for (std::size_t i = nodes.size(); i-- > 0;) {
    TreeNode& node = nodes[i];
    filled[i] = std::isnan(node.end_radius_m);
    if (filled[i]) {
      ++(borne[i] > 0 ? repair.from_branches : repair.tips);
      node.end_radius_m = borne[i] > 0 ? std::sqrt(borne[i]) : tip_radius_m;
    }
    const double start_m = std::isnan(node.start_radius_m) ? node.end_radius_m : node.start_radius_m;
    if (node.parent != TreeNode::kNoParent) borne[static_cast<std::size_t>(node.parent)] += start_m * start_m;
  }
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    TreeNode& node = nodes[i];
    const TreeNode& bearer = nodes[static_cast<std::size_t>(node.parent)];
    if (filled[i]) node.end_radius_m = std::min(node.end_radius_m, bearer.end_radius_m);
    if (std::isnan(node.start_radius_m)) {
      node.start_radius_m = node.order == bearer.order ? bearer.end_radius_m : node.end_radius_m;
    }
  }
  if (!nodes.empty()) nodes.front().start_radius_m = nodes.front().end_radius_m;
  return repair;
}

}  // namespace roseau::structure
