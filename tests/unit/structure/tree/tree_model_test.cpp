// The cantilever, the check and the statistics, on trees whose figures are known by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "structure/tree/cantilever.h"
#include "structure/tree/statistics.h"
#include "structure/tree/tree_check.h"
#include "structure/tree/vector3.h"

namespace roseau::structure {
namespace {

using ::testing::HasSubstr;

TEST(Cantilever, TapersEvenlyFromFootToTip) {
  const auto tree =
      cantilever({.length_m = 3, .start_radius_m = 0.04, .end_radius_m = 0.01, .segment_count = 6, .direction = {0, 0, 5}});
  ASSERT_TRUE(tree) << tree.error().message;
  ASSERT_EQ(tree->segment_count(), 6U);
  for (std::size_t i = 1; i <= 6; ++i) {
    const auto& node = tree->nodes[i];
    EXPECT_NEAR(node.position_m.z, 0.5 * static_cast<double>(i), 1e-12);
    EXPECT_NEAR(node.start_radius_m, 0.04 - 0.005 * static_cast<double>(i - 1), 1e-12);
    EXPECT_NEAR(node.end_radius_m, 0.04 - 0.005 * static_cast<double>(i), 1e-12);
    EXPECT_EQ(node.parent, static_cast<std::int32_t>(i) - 1);
    EXPECT_EQ(node.order, 0);
  }
  EXPECT_TRUE(tree->leaves.empty());
}

TEST(Cantilever, BoardIsCentredOnTheTipAndFacesItsNormal) {
  const auto tree = cantilever({.length_m = 2, .board_leaves = 3, .board_length_m = 0.6, .board_width_m = 0.3});
  ASSERT_TRUE(tree) << tree.error().message;
  ASSERT_EQ(tree->leaves.size(), 9U);
  Vec3 centre;
  for (const auto& leaf : tree->leaves) {
    EXPECT_EQ(leaf.node, tree->nodes.size() - 1);
    EXPECT_NEAR(leaf.normal.y, -1, 1e-12);
    EXPECT_NEAR(leaf.direction.z, 1, 1e-12);
    EXPECT_NEAR(leaf.length_m, 0.2, 1e-12);
    EXPECT_NEAR(leaf.width_m, 0.1, 1e-12);
    centre = centre + (1.0 / 9) * (leaf.base_m + (leaf.length_m / 2) * leaf.direction);
  }
  EXPECT_NEAR(norm(centre - Vec3{0, 0, 2}), 0, 1e-12);
}

TEST(Cantilever, ADisorderlyBoardHasTheSameAreasAndMiddles) {
  const CantileverOptions neat{.length_m = 2, .board_leaves = 5};
  CantileverOptions wild = neat;
  wild.board_disorder = 1;
  const auto a = cantilever(neat);
  const auto b = cantilever(wild);
  ASSERT_TRUE(a && b);
  bool turned = false;
  for (std::size_t i = 0; i < a->leaves.size(); ++i) {
    const Leaf& p = a->leaves[i];
    const Leaf& q = b->leaves[i];
    EXPECT_NEAR(area_m2(p), area_m2(q), 1e-15);
    EXPECT_NEAR(p.base_m.x + p.direction.x * p.length_m / 2, q.base_m.x + q.direction.x * q.length_m / 2, 1e-12);
    EXPECT_NEAR(p.base_m.z + p.direction.z * p.length_m / 2, q.base_m.z + q.direction.z * q.length_m / 2, 1e-12);
    EXPECT_NEAR(q.direction.y, 0, 1e-12);
    turned = turned || std::abs(q.direction.x - p.direction.x) > 0.3;
  }
  EXPECT_TRUE(turned);
}

TEST(Cantilever, BoardAcrossAHorizontalPoleFacingAlongIt) {
  const auto tree = cantilever({.direction = {1, 0, 0}, .board_leaves = 1, .board_length_m = 1, .board_normal = {1, 0, 0}});
  ASSERT_TRUE(tree) << tree.error().message;
  EXPECT_NEAR(std::abs(tree->leaves.front().normal.x), 1, 1e-12);
}

TEST(Cantilever, RefusesSizesThatCannotBe) {
  const auto refused = [](const CantileverOptions& options, const char* what) {
    const auto tree = cantilever(options);
    ASSERT_FALSE(tree);
    EXPECT_THAT(tree.error().message, HasSubstr(what));
  };
  refused({.length_m = 0}, "length");
  refused({.length_m = std::numeric_limits<double>::quiet_NaN()}, "length");
  refused({.start_radius_m = -1}, "radii");
  refused({.segment_count = 0}, "segments");
  refused({.direction = {0, 0, 0}}, "direction");
  refused({.board_leaves = 1000}, "board");
  refused({.board_leaves = 1, .board_disorder = 1.5}, "disorder");
  refused({.board_leaves = 1, .board_width_m = 0}, "board");
  refused({.board_leaves = 1, .board_normal = {0, 0, 0}}, "normal");
}

/// A trunk of 2 m, a branch of 1 m to the east from its middle, and one leaf.
TreeModel fork() {
  return {.name = "fork",
          .nodes = {{},
                    {.position_m = {0, 0, 1}, .parent = 0, .start_radius_m = 0.1, .end_radius_m = 0.1},
                    {.position_m = {0, 0, 2}, .parent = 1, .start_radius_m = 0.06, .end_radius_m = 0.03},
                    {.position_m = {1, 0, 1}, .parent = 1, .start_radius_m = 0.05, .end_radius_m = 0.05, .order = 1}},
          .leaves = {
              {.node = 3, .base_m = {1, 0, 1}, .direction = {1, 0, 0}, .normal = {0, 0, 1}, .length_m = 0.2, .width_m = 0.1}}};
}

TEST(Statistics, OfAForkAreThoseWorkedOutByHand) {
  const auto figures = statistics(fork());
  const double pi = std::numbers::pi;
  EXPECT_EQ(figures.nodes, 4U);
  EXPECT_EQ(figures.tips, 2U);
  EXPECT_DOUBLE_EQ(figures.height_m, 2);
  EXPECT_DOUBLE_EQ(figures.extent_east_m, 1);
  EXPECT_DOUBLE_EQ(figures.extent_north_m, 0);
  EXPECT_DOUBLE_EQ(figures.wood_length_m, 3);
  EXPECT_NEAR(figures.wood_m3, pi * (0.01 + 0.0021 + 0.0025), 1e-12);
  EXPECT_NEAR(figures.radius_at_1_3_m, 0.06 - 0.3 * 0.03, 1e-12);
  EXPECT_DOUBLE_EQ(figures.foot_radius_m, 0.1);
  EXPECT_DOUBLE_EQ(figures.thinnest_radius_m, 0.03);
  EXPECT_NEAR(figures.leaf_area_m2, pi / 4 * 0.02, 1e-12);
  ASSERT_EQ(figures.orders.size(), 2U);
  EXPECT_EQ(figures.orders[0].axes, 1U);
  EXPECT_EQ(figures.orders[0].segments, 2U);
  EXPECT_EQ(figures.orders[1].axes, 1U);
  EXPECT_DOUBLE_EQ(figures.orders[1].length_m, 1);
}

TEST(TreeCheck, AcceptsAForkAndNamesWhatIsWrong) {
  ASSERT_TRUE(check(fork()));
  const auto broken = [](const char* what, auto&& spoil) {
    TreeModel tree = fork();
    spoil(tree);
    const auto checked = check(tree);
    ASSERT_FALSE(checked) << what;
    EXPECT_THAT(checked.error().message, HasSubstr(what));
    EXPECT_THAT(checked.error().message, HasSubstr("fork"));
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  broken("at least one segment", [](TreeModel& t) { t.nodes.resize(1); });
  broken("node 2 has no finite position", [&](TreeModel& t) { t.nodes[2].position_m.y = nan; });
  broken("node 0 is the first", [](TreeModel& t) { t.nodes[0].parent = 0; });
  broken("node 0 is the foot", [](TreeModel& t) { t.nodes[0].position_m.x = 1; });
  broken("node 2 hangs on no other", [](TreeModel& t) { t.nodes[2].parent = TreeNode::kNoParent; });
  broken("node 2 does not come after", [](TreeModel& t) { t.nodes[2].parent = 3; });
  broken("node 2 does not come after", [](TreeModel& t) { t.nodes[2].parent = -7; });
  broken("node 3 has no positive radius", [](TreeModel& t) { t.nodes[3].end_radius_m = 0; });
  broken("node 3 has no positive radius", [&](TreeModel& t) { t.nodes[3].start_radius_m = nan; });
  broken("node 3 has a segment of no length", [](TreeModel& t) { t.nodes[3].position_m = t.nodes[1].position_m; });
  broken("leaf 0 hangs on a node", [](TreeModel& t) { t.leaves[0].node = 4; });
  broken("leaf 0 has no finite position", [&](TreeModel& t) { t.leaves[0].base_m.x = nan; });
  broken("leaf 0 has no positive size", [](TreeModel& t) { t.leaves[0].width_m = 0; });
  broken("leaf 0 has no finite direction", [&](TreeModel& t) { t.leaves[0].normal.x = nan; });
  broken("no unit vector", [](TreeModel& t) { t.leaves[0].direction.x = 2; });
  broken("leans along its blade", [](TreeModel& t) { t.leaves[0].normal = {1, 0, 0}; });
}

}  // namespace
}  // namespace roseau::structure
