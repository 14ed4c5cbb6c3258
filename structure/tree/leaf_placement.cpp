#include "structure/tree/leaf_placement.h"

#include "core/check.h"
#include "structure/tree/vector3.h"

namespace roseau::structure {

Leaf place_leaf(const TreeModel& tree, std::uint32_t node, double along, std::uint32_t index, const LeafShape& shape,
                Dice& dice) {
  ROSEAU_CHECK(node > 0 && node < tree.nodes.size());
  const TreeNode& end = tree.nodes[node];
  const Vec3& start_m = tree.nodes[static_cast<std::size_t>(end.parent)].position_m;
  const Vec3 axis = unit(end.position_m - start_m);
  const double turn_rad = kGoldenAngle_rad * index + dice.uniform(-0.3, 0.3);
  const Vec3 aside = turned(perpendicular(axis, {0, 0, 1}), axis, turn_rad);
  const double forward = dice.uniform(0.3, 0.9);
  const Vec3 stalk = unit(aside + forward * axis + Vec3{0, 0, dice.uniform(0, 0.4)}, aside);
  const double size = dice.uniform(0.75, 1.25);
  const double radius_m = end.start_radius_m + along * (end.end_radius_m - end.start_radius_m);
  const Vec3 swing = 0.35 * dice.cube();
  const Vec3 direction = unit(stalk + swing + Vec3{0, 0, dice.uniform(-0.75, 0.05)}, aside);
  return {.node = node,
          .base_m = start_m + along * (end.position_m - start_m) + (radius_m + size * shape.stalk_m) * stalk,
          .direction = direction,
          .normal = perpendicular(direction, Vec3{0, 0, 1} + 0.55 * dice.cube()),
          .length_m = size * shape.length_m,
          .width_m = size * shape.width_m};
}

}  // namespace roseau::structure
