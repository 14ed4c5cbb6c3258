#include "synthesis/render/foliage.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "synthesis/render/vector_math.h"

namespace roseau::render {

namespace {

constexpr double kBlade = 0.65;         // area of a blade by length times width
constexpr double kSunExtinction = 0.5;  // of light by leaves, per leaf area over ground area
constexpr double kSkyExtinction = 0.30;
constexpr double kSkyFloor = 0.30;  // comes in from the sides
constexpr double kCell_m = 0.15;
constexpr std::uint64_t kTintStream = 205;

Vec3 middle(const structure::Leaf& leaf) { return add(leaf.base_m, times(leaf.length_m / 2, leaf.direction)); }
double area_m2(const structure::Leaf& leaf) { return kBlade * leaf.length_m * leaf.width_m; }

// Sums leaf area over the cells of a plane across a direction of light.
class LightPlane {
 public:
  LightPlane(const structure::TreeModel& tree, const Vec3& to_light) : to_light_(to_light) {
    const Vec3 aside = std::abs(to_light.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
    across_ = unit(cross(to_light, aside));
    along_ = cross(to_light, across_);
    double reach = 1;
    for (const structure::Leaf& leaf : tree.leaves) reach = std::max(reach, length(leaf.base_m) + leaf.length_m);
    for (const structure::TreeNode& node : tree.nodes) reach = std::max(reach, length(node.position_m));
    cells_ = std::clamp(static_cast<int>(2 * reach / kCell_m) + 3, 1, 2000);
    area_m2_.resize(static_cast<std::size_t>(cells_) * static_cast<std::size_t>(cells_));
  }

  double height(const Vec3& point) const { return dot(point, to_light_); }
  double leaf_layers(const Vec3& point) const { return area_m2_[cell(point)] / (kCell_m * kCell_m); }
  void add_area(const Vec3& point, double area) { area_m2_[cell(point)] += area; }

 private:
  std::size_t cell(const Vec3& point) const {
    const auto index = [this](double coordinate) {
      return static_cast<std::size_t>(
          std::clamp(static_cast<int>(std::floor(coordinate / kCell_m)) + cells_ / 2, 0, cells_ - 1));
    };
    return index(dot(point, across_)) * static_cast<std::size_t>(cells_) + index(dot(point, along_));
  }

  Vec3 to_light_;
  Vec3 across_;
  Vec3 along_;
  int cells_;
  std::vector<double> area_m2_;
};

Vec3 segment_middle(const structure::TreeModel& tree, std::size_t node) {
  const auto& its_node = tree.nodes[node];
  if (its_node.parent < 0) return its_node.position_m;
  return times(0.5, add(its_node.position_m, tree.nodes[static_cast<std::size_t>(its_node.parent)].position_m));
}

// Leaf layers above each leaf and each segment, in the direction of light.
void count_layers(const structure::TreeModel& tree, const Vec3& to_light, std::vector<float>& of_leaves,
                  std::vector<float>& of_nodes) {
  LightPlane plane(tree, to_light);
  const std::size_t leaf_count = tree.leaves.size();
  std::vector<double> heights;
  for (const structure::Leaf& leaf : tree.leaves) heights.push_back(plane.height(middle(leaf)));
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) heights.push_back(plane.height(segment_middle(tree, i)));
  std::vector<std::size_t> order(heights.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, [&heights](std::size_t a, std::size_t b) { return heights[a] > heights[b]; });
  of_leaves.resize(leaf_count);
  of_nodes.resize(tree.nodes.size());
  for (const std::size_t i : order) {
    if (i < leaf_count) {
      const structure::Leaf& leaf = tree.leaves[i];
      of_leaves[i] = static_cast<float>(plane.leaf_layers(middle(leaf)));
      plane.add_area(middle(leaf), area_m2(leaf) * std::abs(dot(leaf.normal, to_light)));
    } else {
      of_nodes[i - leaf_count] = static_cast<float>(plane.leaf_layers(segment_middle(tree, i - leaf_count)));
    }
  }
}

bool hides_ball(const SceneDescription& description, const structure::Leaf& leaf) {
  const Vec3 at = middle(leaf);
  for (const MarkerBall& ball : description.balls) {
    const Vec3 centre = add(description.tree.nodes[ball.node].position_m, ball.offset_m);
    const double nearest = ball.diameter_m / 2 + description.clearance_m;
    for (const Vec3& viewpoint : description.viewpoints_in_world_m) {
      const Vec3 sight = subtract(centre, viewpoint);
      const Vec3 to_leaf = subtract(at, viewpoint);
      const double along = std::clamp(dot(to_leaf, sight) / dot(sight, sight), 0.0, 1.0);
      if (length(subtract(to_leaf, times(along, sight))) < nearest) return true;
    }
  }
  return false;
}

VisibleLeaf make_leaf(const structure::TreeModel& tree, const structure::Leaf& leaf) {
  // Along and across the blade, in shares of its length and half width.
  constexpr double kOutline[VisibleLeaf::kCorners][2] = {{0, 0}, {0.30, 1}, {0.70, 0.76}, {1, 0}, {0.70, -0.76}, {0.30, -1}};
  VisibleLeaf visible{.node = leaf.node, .normal = leaf.normal};
  const Vec3 base = subtract(leaf.base_m, tree.nodes[leaf.node].position_m);
  const Vec3 across = cross(leaf.normal, leaf.direction);
  for (std::size_t i = 0; i < VisibleLeaf::kCorners; ++i) {
    visible.corners_m.at(i) =
        add(base, add(times(kOutline[i][0] * leaf.length_m, leaf.direction), times(kOutline[i][1] * leaf.width_m / 2, across)));
  }
  return visible;
}

}  // namespace

CrownLight light_in_crown(const structure::TreeModel& tree, const Vec3& to_sun) {
  CrownLight light;
  std::vector<float> of_nodes;
  count_layers(tree, {0, 0, 1}, light.leaf_skylight, of_nodes);
  for (float& layers : light.leaf_skylight) {
    layers = static_cast<float>(kSkyFloor + (1 - kSkyFloor) * std::exp(-kSkyExtinction * double{layers}));
  }
  count_layers(tree, to_sun, light.leaf_sunlight, light.node_sunlight);
  for (auto* shares : {&light.leaf_sunlight, &light.node_sunlight}) {
    for (float& layers : *shares) layers = static_cast<float>(std::exp(-kSunExtinction * double{layers}));
  }
  return light;
}

std::vector<VisibleLeaf> visible_leaves(const SceneDescription& description, const CrownLight& light) {
  const RandomStream random(description.seed, kTintStream);
  std::vector<VisibleLeaf> leaves;
  for (std::size_t i = 0; i < description.tree.leaves.size(); ++i) {
    const structure::Leaf& leaf = description.tree.leaves[i];
    if (hides_ball(description, leaf)) continue;
    leaves.push_back(make_leaf(description.tree, leaf));
    leaves.back().sunlight = light.leaf_sunlight[i];
    leaves.back().skylight = light.leaf_skylight[i];
    leaves.back().tint = static_cast<std::uint8_t>(random.bits(i) % 4);
  }
  return leaves;
}

GroundShadow cast_shadow(const structure::TreeModel& tree, const Vec3& to_sun) {
  constexpr double kShadowCell_m = 0.1;
  constexpr int kCells = 180;
  constexpr auto kCellCount = static_cast<std::size_t>(kCells) * kCells;
  if (to_sun.z < 0.1) return {};
  std::vector<float> layers(kCellCount);
  const auto deposit = [&](const Vec3& point, double area) {
    const double x = point.x - point.z * to_sun.x / to_sun.z;
    const double y = point.y - point.z * to_sun.y / to_sun.z;
    const auto column = static_cast<int>(std::floor(x / kShadowCell_m)) + kCells / 2;
    const auto row = static_cast<int>(std::floor(y / kShadowCell_m)) + kCells / 2;
    if (column < 1 || row < 1 || column >= kCells - 1 || row >= kCells - 1) return;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const double share = (dx == 0 ? 0.5 : 0.25) * (dy == 0 ? 0.5 : 0.25);
        layers[static_cast<std::size_t>(row + dy) * kCells + static_cast<std::size_t>(column + dx)] +=
            static_cast<float>(share * area / (kShadowCell_m * kShadowCell_m));
      }
    }
  };
  for (const structure::Leaf& leaf : tree.leaves)
    deposit(middle(leaf), area_m2(leaf) * std::abs(dot(leaf.normal, to_sun)) / to_sun.z);
  for (const structure::TreeNode& node : tree.nodes) {
    if (node.parent < 0) continue;
    const Vec3& from = tree.nodes[static_cast<std::size_t>(node.parent)].position_m;
    const double length_m = length(subtract(node.position_m, from));
    const int pieces = std::clamp(static_cast<int>(length_m / kShadowCell_m * 2), 1, 1000);
    for (int i = 0; i < pieces; ++i) {
      deposit(add(from, times((i + 0.5) / pieces, subtract(node.position_m, from))),
              length_m / pieces * (node.start_radius_m + node.end_radius_m));
    }
  }
  for (float& cell : layers) cell = 1 - std::exp(-1.2F * cell);
  return {kShadowCell_m, kCells, std::move(layers)};
}

}  // namespace roseau::render
