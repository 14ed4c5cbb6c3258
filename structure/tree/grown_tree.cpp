#include "structure/tree/grown_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <numeric>
#include <optional>

#include "structure/tree/dice.h"
#include "structure/tree/leaf_placement.h"
#include "structure/tree/tree_check.h"
#include "structure/tree/vector3.h"

namespace roseau::structure {

namespace {

constexpr double kReferenceHeight_m = 5.5;  // step lengths and the like are given for this tree and scale with height
constexpr double kTipRadius_m = 0.0016;
constexpr double kShedGrowthPerMetre = 0.12;  // of the cross-section
constexpr std::size_t kMostNodes = 200'000;

/// What every axis (trunk, branch, ...) of one order does as it grows.
struct GrowthHabit {
  double step_m;       // between nodes
  double length_m;     // most an axis grows, even inside the crown
  double wobble;       // random change of direction per step
  double uprightness;  // pull upwards per step
  double insertion_rad;
  double leafiness;  // leaves per metre, relative
};
constexpr GrowthHabit kHabits[] = {
    {0.24, 40, 0.0, 0.0, 0, 0.35},         // the trunk: its height comes from the options
    {0.29, 2.6, 0.15, 0.055, 1.22, 0.25},  // main branches
    {0.29, 1.10, 0.22, 0.05, 0.90, 0.9},   //
    {0.27, 0.55, 0.20, 0.04, 0.85, 1.0},   //
    {0.12, 0.22, 0.20, 0.03, 0.85, 1.0},
};

enum Stream : std::uint64_t { kCrownStream = 1, kTrunkStream = 2, kLeafStream = 3, kFirstAxisStream = 16 };

/// The space branches grow into: widest at 0.42 of its height, dented by three random waves round it.
class Crown {
 public:
  explicit Crown(const GrownTreeOptions& options)
      : base_m_(options.crown_base_m), depth_m_(options.height_m - base_m_), half_width_m_(options.crown_width_m / 2) {
    Dice dice(options.seed, kCrownStream);
    for (double& phase : phases_) phase = dice.uniform(0, 2 * std::numbers::pi);
  }

  bool holds(const Vec3& point_m) const {
    const double height = (point_m.z - base_m_) / depth_m_;
    const double from_widest = height > kWidest ? (height - kWidest) / (1 - kWidest) : (kWidest - height) / (kWidest + 0.22);
    if (std::abs(from_widest) >= 1) return false;
    const double azimuth = std::atan2(point_m.y, point_m.x);
    const double dent = 1 + 0.07 * std::sin(2 * azimuth + phases_[0]) + 0.06 * std::sin(3 * azimuth + 5 * height + phases_[1]) +
                        0.05 * std::sin(5 * azimuth - 7 * height + phases_[2]);
    const double reach_m = half_width_m_ * dent * std::sqrt(1 - from_widest * from_widest);
    return std::hypot(point_m.x, point_m.y) < reach_m;
  }

 private:
  static constexpr double kWidest = 0.42;
  double base_m_;
  double depth_m_;
  double half_width_m_;
  double phases_[3] = {};
};

class Grower {
 public:
  explicit Grower(const GrownTreeOptions& options)
      : options_(options), crown_(options), size_(options.height_m / kReferenceHeight_m) {}

  Result<TreeModel> grow();

 private:
  struct Axis {
    std::uint32_t from = 0;  // node
    Vec3 direction;
    std::uint16_t order = 0;
    double length_m = 0;  // most it may grow
  };

  std::uint32_t add_node(std::uint32_t parent, const Vec3& position_m, std::uint16_t order);
  void grow_trunk();
  void grow_axis(const Axis& axis, std::uint64_t stream);
  void branch_off(const Axis& bearer, std::uint32_t node, const Vec3& along, double left_m, std::uint64_t index, Dice& dice);
  double segment_length_m(std::uint32_t node) const;
  std::vector<double> leafiness() const;
  Result<void> set_radii(const std::vector<double>& leafiness);
  void set_leaves(const std::vector<double>& leafiness);

  const GrownTreeOptions options_;
  const Crown crown_;
  const double size_;
  TreeModel tree_;
  std::vector<Axis> waiting_;  // axes to grow, in the order they were started
};

std::uint32_t Grower::add_node(std::uint32_t parent, const Vec3& position_m, std::uint16_t order) {
  tree_.nodes.push_back({.position_m = position_m, .parent = static_cast<std::int32_t>(parent), .order = order});
  return static_cast<std::uint32_t>(tree_.nodes.size() - 1);
}

/// Straight steps up to the crown, then one node per main branch, then the tip. The trunk sways about its line but ends at
/// exactly the wanted height.
void Grower::grow_trunk() {
  Dice dice(options_.seed, kTrunkStream);
  const double turn_rad = dice.uniform(0, 2 * std::numbers::pi);
  const double lean = dice.uniform(0.015, 0.03) * options_.height_m;
  const auto axis_at = [&](double z_m) {
    const double share = z_m / options_.height_m;
    const double sway = lean * std::sin(4.2 * share) * share;
    const double bow = 0.6 * lean * (1 - std::cos(6.5 * share)) * share;
    return Vec3{sway * std::cos(turn_rad) - bow * std::sin(turn_rad), sway * std::sin(turn_rad) + bow * std::cos(turn_rad),
                z_m};
  };
  tree_.nodes.push_back({});
  std::uint32_t top = 0;
  const double step_m = kHabits[0].step_m * size_;
  const auto bare = static_cast<int>(std::ceil(options_.crown_base_m / step_m));
  for (int i = 1; i < bare; ++i) top = add_node(top, axis_at(options_.crown_base_m * i / bare), 0);
  const double first_m = std::max(options_.crown_base_m, 0.02 * options_.height_m);
  const double crown_depth_m = options_.height_m - first_m;
  for (std::uint32_t i = 0; i < options_.main_branch_count; ++i) {
    // Spaced more closely towards the top, as the shoots of each year are shorter.
    const double share = (i + (i == 0 ? 0 : dice.uniform(-0.25, 0.25))) / options_.main_branch_count;
    const double z_m = first_m + 0.95 * crown_depth_m * std::pow(share, 0.9);
    top = add_node(top, axis_at(z_m), 0);
    const double azimuth_rad = turn_rad + kGoldenAngle_rad * i + dice.uniform(-0.25, 0.25);
    const double from_vertical_rad = kHabits[1].insertion_rad * (1.1 - 0.65 * share) + dice.uniform(-0.1, 0.1);
    const Vec3 direction{std::sin(from_vertical_rad) * std::cos(azimuth_rad),
                         std::sin(from_vertical_rad) * std::sin(azimuth_rad), std::cos(from_vertical_rad)};
    waiting_.push_back({.from = top, .direction = direction, .order = 1, .length_m = kHabits[1].length_m * size_});
  }
  add_node(top, axis_at(options_.height_m), 0);
}

void Grower::branch_off(const Axis& bearer, std::uint32_t node, const Vec3& along, double left_m, std::uint64_t index,
                        Dice& dice) {
  const auto order = static_cast<std::uint16_t>(bearer.order + 1);
  if (order > options_.branching_orders) return;
  const GrowthHabit& habit = kHabits[order];
  // Branches of branches lie in a plane, more or less: they alternate right and left rather than all round.
  const Vec3 upper = perpendicular(along, {0, 0, 1});
  const double side = index % 2 == 0 ? 1 : -1;
  const double roll_rad = side * (1.35 + dice.uniform(-0.55, 0.45));
  const double angle_rad = habit.insertion_rad + dice.uniform(-0.2, 0.2);
  const Vec3 aside = turned(upper, along, roll_rad);
  const double length_m = std::min(habit.length_m * size_, 0.35 * habit.length_m * size_ + 0.55 * left_m);
  waiting_.push_back({.from = node,
                      .direction = std::cos(angle_rad) * along + std::sin(angle_rad) * aside,
                      .order = order,
                      .length_m = length_m * dice.uniform(0.7, 1.15)});
}

void Grower::grow_axis(const Axis& axis, std::uint64_t stream) {
  Dice dice(options_.seed, stream);
  const GrowthHabit& habit = kHabits[axis.order];
  Vec3 direction = unit(axis.direction);
  std::uint32_t top = axis.from;
  double grown_m = 0;
  for (std::uint64_t i = 0; tree_.nodes.size() < kMostNodes; ++i) {
    const double step_m = habit.step_m * size_ * dice.uniform(0.8, 1.2);
    if (i > 0 && grown_m + step_m / 2 > axis.length_m) break;
    direction = unit(direction + habit.wobble * dice.cube() + Vec3{0, 0, habit.uprightness});
    const Vec3 next_m = tree_.nodes[top].position_m + step_m * direction;
    if (!crown_.holds(next_m)) break;
    if (i > 0) branch_off(axis, top, direction, axis.length_m - grown_m, i, dice);
    top = add_node(top, next_m, axis.order);
    grown_m += step_m;
  }
}

double Grower::segment_length_m(std::uint32_t node) const {
  const TreeNode& end = tree_.nodes[node];
  return distance(end.position_m, tree_.nodes[static_cast<std::size_t>(end.parent)].position_m);
}

/// Of each node's segment: the share of the tree's leaves on it.
std::vector<double> Grower::leafiness() const {
  std::vector<double> all(tree_.nodes.size(), 0.0);
  for (std::uint32_t i = 1; i < tree_.nodes.size(); ++i) {
    const TreeNode& node = tree_.nodes[i];
    // Old wood inside the crown is bare: leaves are where the light is, on the outer part of the thick axes.
    const double out = std::hypot(node.position_m.x, node.position_m.y) / (options_.crown_width_m / 2);
    const double up = (node.position_m.z - options_.crown_base_m) / (options_.height_m - options_.crown_base_m);
    const double light = node.order >= 2 ? 0.35 + 0.65 * std::min(1.0, std::hypot(out, std::max(0.0, up)))
                                         : std::max({0.0, 2 * out - 1, 5 * up - 4});
    all[i] = kHabits[node.order].leafiness * light * segment_length_m(i);
  }
  double total = std::accumulate(all.begin(), all.end(), 0.0);
  if (total <= 0) {  // a few short branches, all in the shade: the tips bear the leaves
    for (std::uint32_t i = 1; i < tree_.nodes.size(); ++i) all[i] = i + 1 == tree_.nodes.size() ? 1 : 0;
    total = 1;
  }
  for (double& share : all) share /= total;
  return all;
}

/// From the tips down. The section under the whole tree is linear in what a leaf needs; that follows from the trunk's radius.
Result<void> Grower::set_radii(const std::vector<double>& leafiness) {
  const auto sections = [&](double per_leaf_share, double per_tip) {
    std::vector<double> above(tree_.nodes.size(), 0.0);  // at the node: the sum over its branches
    std::vector<double> below(tree_.nodes.size(), 0.0);  // at the parent's end
    for (auto i = static_cast<std::uint32_t>(tree_.nodes.size() - 1); i > 0; --i) {
      if (above[i] == 0) above[i] = per_tip;
      below[i] = above[i] * (1 + kShedGrowthPerMetre / size_ * segment_length_m(i)) + per_leaf_share * leafiness[i];
      above[static_cast<std::size_t>(tree_.nodes[i].parent)] += below[i];
    }
    below[0] = above[0];
    return std::pair(std::move(below), std::move(above));
  };
  const double tip = kTipRadius_m * size_ * kTipRadius_m * size_;
  const double wanted = options_.trunk_radius_m * options_.trunk_radius_m;
  const double tips_need = sections(0, tip).first[0];
  if (tips_need >= wanted) {
    return Error{
        ErrorCode::invalid_argument,
        fmt::format("grown tree: a trunk of radius {} m is too thin for its branches: at least {:.4f} m are needed, or "
                    "fewer main branches or orders",
                    options_.trunk_radius_m, 1.05 * std::sqrt(tips_need))};
  }
  const double per_leaf_share = (wanted - tips_need) / (sections(1, tip).first[0] - tips_need);
  const auto [below, above] = sections(per_leaf_share, tip);
  for (std::size_t i = 0; i < tree_.nodes.size(); ++i) {
    tree_.nodes[i].start_radius_m = std::sqrt(below[i]);
    tree_.nodes[i].end_radius_m = std::sqrt(above[i]);
  }
  return {};
}

/// Exactly as many as wanted: a segment gets the leaves that the running sum of the shares passes on it.
void Grower::set_leaves(const std::vector<double>& leafiness) {
  tree_.leaves.reserve(options_.leaf_count);
  const LeafShape shape{options_.leaf_length_m, options_.leaf_width_m, 0.45 * options_.leaf_length_m};
  Dice dice(options_.seed, kLeafStream);
  double sum = 0;
  std::uint32_t placed = 0;
  std::uint32_t last_leafy = 0;
  for (std::uint32_t i = 1; i < tree_.nodes.size(); ++i) {
    if (leafiness[i] > 0) last_leafy = i;
  }
  for (std::uint32_t i = 1; i <= last_leafy; ++i) {
    sum += leafiness[i];
    const auto until = i == last_leafy ? options_.leaf_count
                                       : std::min(options_.leaf_count, static_cast<std::uint32_t>(sum * options_.leaf_count));
    const std::uint32_t count = until - placed;
    for (std::uint32_t k = 0; k < count; ++k) {
      const double along = (k + dice.uniform(0.1, 0.9)) / count;
      tree_.leaves.push_back(place_leaf(tree_, i, along, placed + k, shape, dice));
    }
    placed = until;
  }
}

Result<TreeModel> Grower::grow() {
  tree_.name = fmt::format("grown tree, seed {}", options_.seed);
  grow_trunk();
  // Every axis adds the branches it bears behind those that wait already: order by order, the same for the same options.
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    const Axis axis = waiting_[i];
    grow_axis(axis, kFirstAxisStream + i);
  }
  const auto shares = leafiness();
  if (auto set = set_radii(shares); !set) return set.error();
  set_leaves(shares);
  if (auto checked = check(tree_); !checked) return checked.error();
  return std::move(tree_);
}

std::optional<std::string> fault(const GrownTreeOptions& o) {
  const auto outside = [](const char* what, double value, double low, double high) -> std::optional<std::string> {
    if (value >= low && value <= high) return std::nullopt;  // NaN is outside
    return fmt::format("{} = {} is not between {:.4g} and {:.4g}", what, value, low, high);
  };
  if (auto bad = outside("height_m", o.height_m, 0.5, 40)) return bad;
  if (auto bad = outside("trunk_radius_m", o.trunk_radius_m, o.height_m / 500, o.height_m / 5)) return bad;
  if (auto bad = outside("crown_base_m", o.crown_base_m, 0, 0.8 * o.height_m)) return bad;
  if (auto bad = outside("crown_width_m", o.crown_width_m, 0.1, 2 * o.height_m)) return bad;
  if (auto bad = outside("main_branch_count", o.main_branch_count, 1, 200)) return bad;
  if (auto bad = outside("branching_orders", o.branching_orders, 1, 4)) return bad;
  if (auto bad = outside("leaf_count", o.leaf_count, 0, 500'000)) return bad;
  if (auto bad = outside("leaf_length_m", o.leaf_length_m, 0.005, 1)) return bad;
  return outside("leaf_width_m", o.leaf_width_m, 0.005, 1);
}

}  // namespace

Result<TreeModel> grow_tree(const GrownTreeOptions& options) {
  if (auto bad = fault(options)) return Error{ErrorCode::invalid_argument, "grown tree: " + *bad};
  return Grower(options).grow();
}

}  // namespace roseau::structure
