#include "structure/tree/cantilever.h"

#include <cmath>

#include "structure/tree/dice.h"
#include "structure/tree/tree_check.h"
#include "structure/tree/vector3.h"

namespace roseau::structure {

namespace {

constexpr std::size_t kMostSegments = 100'000;
constexpr std::uint32_t kMostBoardRows = 100;
constexpr std::uint64_t kDisorderSeed = 1;
constexpr double kMostTurn_rad = 1.05;
constexpr double kMostStretch = 1.0 / 3;

const char* fault(const CantileverOptions& options) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  if (!positive(options.length_m)) return "its length must be positive";
  if (!positive(options.start_radius_m) || !positive(options.end_radius_m)) return "its radii must be positive";
  if (options.segment_count < 1 || options.segment_count > kMostSegments) return "it takes 1 to 100000 segments";
  if (!is_finite(options.direction) || norm(options.direction) < 1e-9) return "its direction has no length";
  if (options.board_leaves == 0) return nullptr;
  if (options.board_leaves > kMostBoardRows) return "its board takes at most 100 rows of leaves";
  if (!(options.board_disorder >= 0 && options.board_disorder <= 1)) return "its board's disorder goes from 0 to 1";
  if (!positive(options.board_length_m) || !positive(options.board_width_m)) return "its board must have a positive size";
  return is_finite(options.board_normal) && norm(options.board_normal) > 1e-9 ? nullptr : "its board's normal has no length";
}

void add_board(const CantileverOptions& options, TreeModel& tree) {
  const Vec3 normal = unit(options.board_normal);
  const Vec3 along = perpendicular(normal, unit(options.direction));
  const Vec3 across = cross(normal, along);
  const double rows = options.board_leaves;
  const auto tip = static_cast<std::uint32_t>(tree.nodes.size() - 1);
  Dice dice(kDisorderSeed, 0);
  for (std::uint32_t row = 0; row < options.board_leaves; ++row) {
    for (std::uint32_t column = 0; column < options.board_leaves; ++column) {
      const double angle = options.board_disorder * dice.uniform(-kMostTurn_rad, kMostTurn_rad);
      const double stretch = 1 + options.board_disorder * dice.uniform(-kMostStretch, kMostStretch);
      const Vec3 blade = std::cos(angle) * along + std::sin(angle) * across;
      const double length_m = options.board_length_m / rows * stretch;
      const Vec3 middle = options.board_length_m * ((row + 0.5) / rows - 0.5) * along +
                          options.board_width_m * ((column + 0.5) / rows - 0.5) * across;
      tree.leaves.push_back({.node = tip,
                             .base_m = tree.nodes.back().position_m + middle - (length_m / 2) * blade,
                             .direction = blade,
                             .normal = normal,
                             .length_m = length_m,
                             .width_m = options.board_width_m / rows / stretch});
    }
  }
}

}  // namespace

Result<TreeModel> cantilever(const CantileverOptions& options) {
  if (const char* what = fault(options)) return Error{ErrorCode::invalid_argument, std::string("cantilever: ") + what};
  const Vec3 direction = unit(options.direction);
  const auto share = [&options](std::size_t i) { return static_cast<double>(i) / static_cast<double>(options.segment_count); };
  const auto radius_m = [&](std::size_t i) {
    return options.start_radius_m + share(i) * (options.end_radius_m - options.start_radius_m);
  };
  TreeModel tree{.name = "cantilever", .nodes = {TreeNode{}}};
  for (std::size_t i = 1; i <= options.segment_count; ++i) {
    tree.nodes.push_back({.position_m = (options.length_m * share(i)) * direction,
                          .parent = static_cast<std::int32_t>(i - 1),
                          .start_radius_m = radius_m(i - 1),
                          .end_radius_m = radius_m(i)});
  }
  tree.nodes.front().start_radius_m = tree.nodes.front().end_radius_m = options.start_radius_m;
  if (options.board_leaves > 0) add_board(options, tree);
  if (auto checked = check(tree); !checked) return checked.error();
  return tree;
}

}  // namespace roseau::structure
