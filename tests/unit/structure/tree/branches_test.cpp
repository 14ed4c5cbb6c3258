#include "structure/tree/branches.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "structure/tree/cantilever.h"
#include "structure/tree/grown_tree.h"
#include "structure/tree/statistics.h"
#include "structure/tree/vector3.h"

namespace roseau::structure {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// A trunk 0-1-2 of two metres; on node 1 a thin branch 3-4 of 2 m with a side branch 5, on node 2 a thick stump 6.
TreeModel espalier() {
  const auto node = [](Vec3 position_m, std::int32_t parent, double radius_m, std::uint16_t order) {
    return TreeNode{position_m, parent, radius_m, radius_m, order};
  };
  return {.name = "espalier",
          .nodes = {node({0, 0, 0}, TreeNode::kNoParent, 0.1, 0), node({0, 0, 1}, 0, 0.1, 0), node({0, 0, 2}, 1, 0.1, 0),
                    node({1, 0, 1}, 1, 0.02, 1), node({2, 0, 1}, 3, 0.02, 1), node({1, 0.5, 1}, 3, 0.01, 2),
                    node({-0.5, 0, 2}, 2, 0.08, 1)},
          .leaves = {{.node = 5, .direction = {1, 0, 0}, .normal = {0, 0, 1}, .length_m = 0.2, .width_m = 0.1}}};
}

TEST(Branches, AreThoseOnTheTrunkWithMostWoodFirst) {
  const TreeModel tree = espalier();
  const auto branches = main_branches(tree);
  ASSERT_EQ(branches.size(), 2U);
  EXPECT_EQ(branches[0].first, 6U);
  EXPECT_EQ(branches[0].tip, 6U);
  EXPECT_EQ(branches[1].first, 3U);
  EXPECT_EQ(branches[1].tip, 4U);
  EXPECT_EQ(branches[1].segments, 3U);
  EXPECT_DOUBLE_EQ(branches[1].reach_m, 2);
  EXPECT_NEAR(branches[1].wood_m3, wood_volume_m3(2, 0.02, 0.02) + wood_volume_m3(0.5, 0.01, 0.01), 1e-15);
  EXPECT_DOUBLE_EQ(branches[1].leaf_area_m2, area_m2(tree.leaves[0]));
  EXPECT_EQ(branches[0].leaf_area_m2, 0);
}

TEST(Branches, NodeAlongABranchIsNeverTheTrunks) {
  const TreeModel tree = espalier();
  const auto branch = main_branches(tree)[1];
  EXPECT_EQ(node_along(tree, branch, 1), 4U);
  EXPECT_EQ(node_along(tree, branch, 0.9), 3U);
  EXPECT_EQ(node_along(tree, branch, 0.5), 3U);
  EXPECT_EQ(node_along(tree, branch, 0), 3U);
}

TEST(Branches, OfABarePoleAreNone) { EXPECT_THAT(main_branches(*cantilever({})), IsEmpty()); }

TEST(Branches, PathsAndSubtrees) {
  const TreeModel tree = espalier();
  EXPECT_THAT(path_to_foot(tree, 5), ElementsAre(5, 3, 1, 0));
  EXPECT_THAT(path_to_foot(tree, 0), ElementsAre(0));
  EXPECT_THAT(subtree(tree, 3), ElementsAre(3, 4, 5));
  EXPECT_THAT(subtree(tree, 2), ElementsAre(2, 6));
  EXPECT_THAT(children(tree)[1], ElementsAre(2, 3));
  EXPECT_EQ(nearest_node(tree, {1.9, 0.1, 1.2}), 4U);
  EXPECT_EQ(nearest_node(tree, {0, 0, -5}), 0U);
}

TEST(Branches, OfAGrownTreeHoldAllItsWoodBesideTheTrunk) {
  const auto tree = grow_tree({.seed = 4});
  ASSERT_TRUE(tree);
  const auto figures = statistics(*tree);
  double wood_m3 = figures.orders[0].wood_m3;
  std::size_t segments = figures.orders[0].segments;
  for (const auto& branch : main_branches(*tree)) {
    wood_m3 += branch.wood_m3;
    segments += branch.segments;
    EXPECT_EQ(tree->nodes[branch.first].order, 1);
    EXPECT_EQ(subtree(*tree, branch.first).size(), branch.segments);
  }
  EXPECT_NEAR(wood_m3, figures.wood_m3, 1e-12);
  EXPECT_EQ(segments, figures.segments);
}

}  // namespace
}  // namespace roseau::structure
