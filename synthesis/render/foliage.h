// Leaves made ready for drawing, and the light that reaches them and the wood through the crown.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "synthesis/render/landscape.h"
#include "synthesis/render/scene_description.h"

namespace roseau::render {

struct VisibleLeaf {
  static constexpr std::size_t kCorners = 6;
  std::uint32_t node = 0;
  /// From the node, at rest: the base of the blade, then around it; the tip is corner 3.
  std::array<Vec3, kCorners> corners_m;
  Vec3 normal;
  float sunlight = 1;  // share of the sun that other leaves let through
  float skylight = 1;
  std::uint8_t tint = 0;  // 0..3: no two neighbours of one green
};

/// Light at each of some places in a crown, by the leaf area between it and the sun, or the sky above.
struct CrownLight {
  std::vector<float> leaf_sunlight;  // per leaf of the tree
  std::vector<float> leaf_skylight;
  std::vector<float> node_sunlight;  // per node: at the middle of its segment
};

CrownLight light_in_crown(const structure::TreeModel& tree, const Vec3& to_sun);

/// The leaves to draw: those that hide no ball.
std::vector<VisibleLeaf> visible_leaves(const SceneDescription& description, const CrownLight& light);

/// The tree's shadow on the ground.
GroundShadow cast_shadow(const structure::TreeModel& tree, const Vec3& to_sun);

}  // namespace roseau::render
