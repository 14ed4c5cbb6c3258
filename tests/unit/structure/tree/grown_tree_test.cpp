#include "structure/tree/grown_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "core/random.h"
#include "structure/tree/statistics.h"
#include "structure/tree/tree_check.h"
#include "structure/tree/vector3.h"

namespace roseau::structure {
namespace {

/// One number of all the bits of a tree.
std::uint64_t fingerprint(const TreeModel& tree) {
  std::uint64_t hash = tree.nodes.size();
  const auto add = [&hash](double value) { hash = scatter_bits(hash ^ std::bit_cast<std::uint64_t>(value)); };
  const auto add_vector = [&add](const Vec3& v) {
    add(v.x);
    add(v.y);
    add(v.z);
  };
  for (const auto& node : tree.nodes) {
    add_vector(node.position_m);
    add(node.parent);
    add(node.start_radius_m);
    add(node.end_radius_m);
    add(node.order);
  }
  for (const auto& leaf : tree.leaves) {
    add(leaf.node);
    add_vector(leaf.base_m);
    add_vector(leaf.direction);
    add_vector(leaf.normal);
    add(leaf.length_m);
    add(leaf.width_m);
  }
  return hash;
}

TEST(GrownTree, DefaultIsAYoungBroadLeavedTree) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const auto tree = grow_tree({.seed = seed});
    ASSERT_TRUE(tree) << tree.error().message;
    const auto figures = statistics(*tree);
    EXPECT_DOUBLE_EQ(figures.height_m, 5.5);
    EXPECT_NEAR(figures.foot_radius_m, 0.07, 1e-12);
    EXPECT_EQ(figures.leaves, 4000U);
    EXPECT_GT(figures.nodes, 450U);
    EXPECT_LT(figures.nodes, 750U);
    EXPECT_GT(std::min(figures.extent_east_m, figures.extent_north_m), 3.2);
    EXPECT_LT(std::max(figures.extent_east_m, figures.extent_north_m), 4.8);
    ASSERT_EQ(figures.orders.size(), 4U);
    EXPECT_EQ(figures.orders[0].axes, 1U);
    EXPECT_GE(figures.orders[1].axes, 15U);
    EXPECT_GT(figures.orders[0].wood_m3, figures.orders[1].wood_m3);
    EXPECT_GT(figures.orders[1].wood_m3, figures.orders[3].wood_m3);
    for (const auto& node : tree->nodes) {
      if (node.order == 1) {
        EXPECT_GT(node.position_m.z, 1.2);
      }
    }
  }
}

TEST(GrownTree, CrossSectionIsKeptAtEveryFork) {
  const auto tree = grow_tree({.seed = 5});
  ASSERT_TRUE(tree);
  std::vector<double> above(tree->nodes.size(), 0.0);
  for (std::size_t i = 1; i < tree->nodes.size(); ++i) {
    const auto& node = tree->nodes[i];
    above[static_cast<std::size_t>(node.parent)] += node.start_radius_m * node.start_radius_m;
    EXPECT_GT(node.start_radius_m, node.end_radius_m);
  }
  int forks = 0;
  for (std::size_t i = 1; i < tree->nodes.size(); ++i) {
    if (above[i] == 0) continue;
    ++forks;
    EXPECT_NEAR(std::sqrt(above[i]), tree->nodes[i].end_radius_m, 1e-12);
  }
  EXPECT_GT(forks, 200);
}

TEST(GrownTree, SameSeedGivesTheSameBitsAnotherSeedAnotherTree) {
  const GrownTreeOptions options{.seed = 77, .height_m = 6};
  const auto first = fingerprint(*grow_tree(options));
  EXPECT_EQ(fingerprint(*grow_tree(options)), first);
  EXPECT_NE(fingerprint(*grow_tree({.seed = 78, .height_m = 6})), first);
}

TEST(GrownTree, OptionsAreObeyed) {
  const auto tree = grow_tree({.seed = 3,
                               .height_m = 12,
                               .trunk_radius_m = 0.2,
                               .crown_base_m = 4,
                               .crown_width_m = 7,
                               .main_branch_count = 25,
                               .branching_orders = 2,
                               .leaf_count = 1234,
                               .leaf_length_m = 0.2});
  ASSERT_TRUE(tree) << tree.error().message;
  const auto figures = statistics(*tree);
  EXPECT_DOUBLE_EQ(figures.height_m, 12);
  EXPECT_NEAR(figures.foot_radius_m, 0.2, 1e-12);
  EXPECT_EQ(figures.orders.size(), 3U);
  EXPECT_EQ(figures.leaves, 1234U);
  EXPECT_LT(std::max(figures.extent_east_m, figures.extent_north_m), 7 * 1.2);
  double length_m = 0;
  for (const auto& leaf : tree->leaves) length_m += leaf.length_m / 1234;
  EXPECT_NEAR(length_m, 0.2, 0.01);
}

TEST(GrownTree, LeavesHangOnTheirSegmentsAndLookUp) {
  const auto tree = grow_tree({});
  ASSERT_TRUE(tree);
  double upwards = 0;
  for (const auto& leaf : tree->leaves) {
    const auto& node = tree->nodes[leaf.node];
    const auto& from_m = tree->nodes[static_cast<std::size_t>(node.parent)].position_m;
    const Vec3 axis = unit(node.position_m - from_m);
    const double along = std::clamp(dot(leaf.base_m - from_m, axis), 0.0, distance(from_m, node.position_m));
    EXPECT_LT(distance(leaf.base_m, from_m + along * axis), 0.12);
    upwards += leaf.normal.z;
  }
  EXPECT_GT(upwards / static_cast<double>(tree->leaves.size()), 0.4);
}

TEST(GrownTree, SmallestAndBareTreesAreTrees) {
  EXPECT_TRUE(grow_tree({.height_m = 0.5, .trunk_radius_m = 0.01, .crown_base_m = 0, .crown_width_m = 0.1}));
  const auto bare = grow_tree({.main_branch_count = 1, .branching_orders = 1, .leaf_count = 0});
  ASSERT_TRUE(bare);
  EXPECT_TRUE(bare->leaves.empty());
}

TEST(GrownTree, RefusesWhatCannotGrow) {
  const auto refused = [](const GrownTreeOptions& options, const char* name) {
    const auto tree = grow_tree(options);
    ASSERT_FALSE(tree) << name;
    EXPECT_EQ(tree.error().code, ErrorCode::invalid_argument);
    EXPECT_THAT(tree.error().message, testing::HasSubstr(name));
  };
  refused({.height_m = 0.1}, "height_m");
  refused({.height_m = std::numeric_limits<double>::quiet_NaN()}, "height_m");
  refused({.trunk_radius_m = 2}, "trunk_radius_m");
  refused({.trunk_radius_m = 0.015}, "too thin");
  refused({.crown_base_m = 5}, "crown_base_m");
  refused({.crown_width_m = 0}, "crown_width_m");
  refused({.main_branch_count = 0}, "main_branch_count");
  refused({.branching_orders = 9}, "branching_orders");
  refused({.leaf_count = 2'000'000'000}, "leaf_count");
  refused({.leaf_length_m = -1}, "leaf_length_m");
  refused({.leaf_width_m = 3}, "leaf_width_m");
}

}  // namespace
}  // namespace roseau::structure
