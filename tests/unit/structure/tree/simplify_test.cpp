#include "structure/tree/simplify.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "structure/tree/cantilever.h"
#include "structure/tree/grown_tree.h"
#include "structure/tree/statistics.h"
#include "structure/tree/tree_check.h"
#include "structure/tree/tree_file.h"
#include "structure/tree/vector3.h"
#include "tests/support/data.h"

namespace roseau::structure {
namespace {

/// Every node of the smaller tree stands where one of the larger stood.
void expect_places_kept(const TreeModel& smaller, const TreeModel& larger) {
  std::map<std::tuple<double, double, double>, int> places;
  for (const auto& node : larger.nodes) ++places[{node.position_m.x, node.position_m.y, node.position_m.z}];
  for (const auto& node : smaller.nodes) {
    EXPECT_EQ(places.count({node.position_m.x, node.position_m.y, node.position_m.z}), 1U);
  }
}

TEST(Simplify, StraightPoleBecomesOneSegmentOfTheSameWood) {
  const auto pole = cantilever({.length_m = 2, .start_radius_m = 0.03, .end_radius_m = 0.01, .board_leaves = 2});
  ASSERT_TRUE(pole);
  const auto simple = simplify(*pole, {.merge_within_m = 1e-9});
  ASSERT_TRUE(simple) << simple.error().message;
  ASSERT_EQ(simple->tree.nodes.size(), 2U);
  EXPECT_EQ(simple->merged_nodes, 19U);
  EXPECT_NEAR(simple->tree.nodes[1].start_radius_m, 0.03, 1e-9);  // a cone of cones is that cone
  EXPECT_NEAR(simple->tree.nodes[1].end_radius_m, 0.01, 1e-9);
  EXPECT_EQ(simple->tree.leaves.size(), 4U);
  EXPECT_EQ(simple->tree.leaves[0].node, 1U);
}

TEST(Simplify, OnlyNodesNearTheStraightLineAreMerged) {
  TreeModel bent{.name = "bent", .nodes = {{}}};
  for (const Vec3& position_m : {Vec3{0, 0, 1}, Vec3{0.2, 0, 2}, Vec3{0.201, 0, 3}, Vec3{0.202, 0, 4}}) {
    bent.nodes.push_back({.position_m = position_m,
                          .parent = static_cast<std::int32_t>(bent.nodes.size() - 1),
                          .start_radius_m = 0.02,
                          .end_radius_m = 0.02});
  }
  const auto simple = simplify(bent, {.merge_within_m = 0.01});
  ASSERT_TRUE(simple);
  EXPECT_EQ(simple->merged_nodes, 1U);
  EXPECT_EQ(simple->tree.nodes.size(), 4U);
}

TEST(Simplify, ThinTwigsGiveTheirWoodAndLeavesToTheirBearers) {
  TreeModel tree{
      .name = "twig",
      .nodes = {{},
                {.position_m = {0, 0, 1}, .parent = 0, .start_radius_m = 0.02, .end_radius_m = 0.02},
                {.position_m = {0, 0, 2}, .parent = 1, .start_radius_m = 0.02, .end_radius_m = 0.02},
                {.position_m = {1, 0, 1}, .parent = 1, .start_radius_m = 0.004, .end_radius_m = 0.002, .order = 1}},
      .leaves = {
          {.node = 3, .base_m = {1, 0, 1}, .direction = {1, 0, 0}, .normal = {0, 0, 1}, .length_m = 0.1, .width_m = 0.1}}};
  const auto simple = simplify(tree, {.drop_below_radius_m = 0.0031});
  ASSERT_TRUE(simple);
  EXPECT_EQ(simple->dropped_twigs, 1U);
  ASSERT_EQ(simple->tree.nodes.size(), 3U);
  EXPECT_NEAR(statistics(simple->tree).wood_m3, statistics(tree).wood_m3, 1e-15);
  EXPECT_GT(simple->tree.nodes[1].end_radius_m, 0.02);
  EXPECT_DOUBLE_EQ(simple->tree.nodes[2].end_radius_m, 0.02);  // not borne through it
  EXPECT_EQ(simple->tree.leaves[0].node, 1U);
  EXPECT_DOUBLE_EQ(simple->tree.leaves[0].base_m.x, 1);
  EXPECT_EQ(simplify(tree, {.drop_below_radius_m = 0.0029})->dropped_twigs, 0U);
}

TEST(Simplify, BudgetIsKeptWithWoodLeavesAndPlaces) {
  const auto grown = grow_tree({.seed = 2});
  ASSERT_TRUE(grown);
  const auto before = statistics(*grown);
  for (const std::size_t budget : {600U, 400U, 150U, 40U, 5U}) {
    const auto simple = simplify(*grown, {.node_budget = budget});
    ASSERT_TRUE(simple) << simple.error().message;
    const auto after = statistics(simple->tree);
    EXPECT_EQ(after.nodes, budget);
    EXPECT_EQ(simple->merged_nodes + simple->dropped_twigs, before.nodes - budget);
    EXPECT_NEAR(after.wood_m3, before.wood_m3, 1e-12);
    EXPECT_EQ(after.leaves, before.leaves);
    EXPECT_DOUBLE_EQ(after.leaf_area_m2, before.leaf_area_m2);
    expect_places_kept(simple->tree, *grown);
    // The thickest wood goes last: down to a quarter of the nodes the trunk is as it was, but for what twigs add to it.
    if (budget >= 150) {
      EXPECT_NEAR(after.radius_at_1_3_m, before.radius_at_1_3_m, 0.002);
      EXPECT_NEAR(after.height_m, before.height_m, 0.15);
    }
  }
}

TEST(Simplify, SameTreeGivesTheSameResult) {
  const auto grown = grow_tree({.seed = 9});
  const auto first = simplify(*grown, {.node_budget = 200});
  const auto second = simplify(*grown, {.node_budget = 200});
  ASSERT_TRUE(first && second);
  for (std::size_t i = 0; i < 200; ++i) {
    EXPECT_EQ(first->tree.nodes[i].end_radius_m, second->tree.nodes[i].end_radius_m);
    EXPECT_EQ(first->tree.nodes[i].parent, second->tree.nodes[i].parent);
  }
}

TEST(Simplify, RefusesWhatMakesNoSense) {
  const auto pole = cantilever({});
  EXPECT_FALSE(simplify(*pole, {.node_budget = 1}));
  EXPECT_FALSE(simplify(*pole, {.merge_within_m = -1}));
  TreeModel broken = *pole;
  broken.nodes[3].end_radius_m = -1;
  EXPECT_FALSE(simplify(broken, {}));
  // Two stems from one foot cannot become one.
  TreeModel twin = *cantilever({.segment_count = 1});
  twin.nodes.push_back(twin.nodes[1]);
  twin.nodes.back().position_m.x = 1;
  const auto refused = simplify(twin, {.node_budget = 2});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, ::testing::HasSubstr("only to 3"));
}

TEST(Simplify, DigitisedWalnutComesDownToAThousandNodes) {
  ROSEAU_REQUIRE_DATA(path, "data/mtg_walnut/noylum2.mtg");
  const auto walnut = read_tree(path);
  ASSERT_TRUE(walnut);
  const auto simple = simplify(walnut->tree, {.node_budget = 1000});
  ASSERT_TRUE(simple) << simple.error().message;
  const auto before = statistics(walnut->tree);
  const auto after = statistics(simple->tree);
  EXPECT_EQ(after.nodes, 1000U);
  EXPECT_NEAR(after.wood_m3 / before.wood_m3, 1, 1e-9);
  EXPECT_NEAR(after.height_m, before.height_m, 0.1);
  EXPECT_EQ(after.leaves, 6837U);
}

}  // namespace
}  // namespace roseau::structure
