#include "structure/tree/mtg.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "structure/tree/mtg_text.h"
#include "structure/tree/statistics.h"
#include "structure/tree/vector3.h"
#include "tests/support/data.h"

namespace roseau::structure {
namespace {

using ::testing::HasSubstr;

constexpr const char* kHead =
    "CODE:\tFORM-A\n\nCLASSES:\nSYMBOL\tSCALE\tDECOMPOSITION\tINDEXATION\tDEFINITION\n"
    "$\t0\tFREE\tFREE\tIMPLICIT\nP\t1\tCONNECTED\tFREE\tEXPLICIT\nA\t2\tLINEAR\tFREE\tEXPLICIT\n"
    "S\t3\tFREE\tFREE\tEXPLICIT\n\nDESCRIPTION :\nLEFT\tRIGHT\tRELTYPE\tMAX\nS\tS\t+\t?\nS\tS\t<\t1\n\n"
    "FEATURES:\nNAME\tTYPE\nXX\tREAL\nYY\tREAL\nZZ\tREAL\nTopDia\tREAL\nNFe\tINT\n\nMTG:\n";
constexpr const char* kColumns = "ENTITY-CODE\t\t\t\tXX\tYY\tZZ\tTopDia\tNFe\n";

/// Entity lines as they stand under three entity columns and one more; "|" stands for the tab.
std::string mtg(std::string entities, const std::string& columns = kColumns) {
  for (char& c : entities) {
    if (c == '|') c = '\t';
  }
  return kHead + columns + entities;
}

/// A trunk of two elements with one branch, base and tips given; centimetres and millimetres.
constexpr const char* kFork =
    "/P1\n"
    "|/A1|||5|6|7|100\n"
    "|^/S1|||5|6|107|80\n"
    "||+A2||5|8|107|20\n"
    "||^/S1||5|58|107|16|3\n"
    "|^<S2|||5|6|207|60\n";

ImportedTree imported(const std::string& text, const MtgOptions& options = {}) {
  auto tree = read_mtg(text, "test.mtg", options);
  EXPECT_TRUE(tree) << tree.error().message;
  return tree ? std::move(*tree) : ImportedTree{};
}

std::size_t noted(const ImportedTree& tree, const std::string& what) {
  for (const auto& note : tree.notes) {
    if (note.what.find(what) != std::string::npos) return note.count;
  }
  return 0;
}

void refused(const std::string& text, const std::string& what, const MtgOptions& options = {}) {
  const auto tree = read_mtg(text, "test.mtg", options);
  ASSERT_FALSE(tree) << what;
  EXPECT_THAT(tree.error().message, HasSubstr(what));
}

std::string file_text(const std::filesystem::path& path) {
  const std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

void expect_point(const Vec3& found, const Vec3& expected) {
  EXPECT_NEAR(distance(found, expected), 0, 1e-12) << found.x << ' ' << found.y << ' ' << found.z;
}

TEST(Mtg, ForkIsReadWithItsUnitsAndRelations) {
  const auto read = imported(mtg(kFork));
  const auto& nodes = read.tree.nodes;
  ASSERT_EQ(nodes.size(), 5U);
  EXPECT_EQ(read.elements, 6U);
  EXPECT_EQ(read.placed_elements, 5U);
  EXPECT_TRUE(read.notes.empty());
  expect_point(read.foot_in_source_m, {0.05, 0.06, 0.07});
  expect_point(nodes[1].position_m, {0, 0, 1});     // S1
  expect_point(nodes[2].position_m, {0, 0.02, 1});  // where the branch begins
  expect_point(nodes[3].position_m, {0, 0.52, 1});  // its tip
  expect_point(nodes[4].position_m, {0, 0, 2});     // S2
  EXPECT_EQ(nodes[1].parent, 0);
  EXPECT_EQ(nodes[2].parent, 1);
  EXPECT_EQ(nodes[3].parent, 2);
  EXPECT_EQ(nodes[4].parent, 1);
  EXPECT_DOUBLE_EQ(nodes[1].start_radius_m, 0.05);
  EXPECT_DOUBLE_EQ(nodes[1].end_radius_m, 0.04);
  EXPECT_DOUBLE_EQ(nodes[2].start_radius_m, 0.01);  // wood as thick as the branch's base joins it to its bearer
  EXPECT_DOUBLE_EQ(nodes[3].start_radius_m, 0.01);
  EXPECT_DOUBLE_EQ(nodes[3].end_radius_m, 0.008);
  EXPECT_DOUBLE_EQ(nodes[4].start_radius_m, 0.04);
  EXPECT_EQ(nodes[3].order, 1);
  EXPECT_EQ(nodes[4].order, 0);
  ASSERT_EQ(read.tree.leaves.size(), 3U);
  EXPECT_EQ(read.tree.leaves[0].node, 3U);
}

TEST(Mtg, LeavesAreAsManyAsTheColumnSaysAndTheSameEachTime) {
  const std::string text = mtg("/P1\n|/A1|||0|0|0|9\n|^/S1|||0|0|50|8|5\n|^<S2|||0|0|90|8|-9\n|^<S3|||0|0|99|8|9000\n");
  const auto read = imported(text, {.leaf_length_m = 0.1});
  ASSERT_EQ(read.tree.leaves.size(), 5U);
  EXPECT_EQ(noted(read, "below zero"), 1U);
  EXPECT_EQ(noted(read, "above 500"), 1U);
  const auto again = imported(text, {.leaf_length_m = 0.1});
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(read.tree.leaves[i].length_m, 0.1, 0.026);
    expect_point(read.tree.leaves[i].base_m, again.tree.leaves[i].base_m);
  }
  EXPECT_TRUE(imported(text, {.leaf_count_column = ""}).tree.leaves.empty());
}

TEST(Mtg, ChainsOnOneLineMeanTheSameAsOneEach) {
  const auto read = imported(mtg("/P1/A1||||0|0|0|50\n^/S1||||0|0|10|40\n^<S2<S3+A2/S9|||||\n"));
  EXPECT_EQ(read.elements, 7U);
  EXPECT_EQ(read.tree.nodes.size(), 2U);
  EXPECT_EQ(noted(read, "left out"), 3U);  // S2, S3 and S9
}

TEST(Mtg, SuccessionOfAWholeGoesOnFromItsLastPart) {
  // A2 follows A1: its first part grows out of A1's last.
  const auto read = imported(mtg("/P1\n|/A1|||0|0|0|50\n|^/S1|||0|0|100|40\n|^<A2\n|^/S1|||0|0|200|30\n"));
  ASSERT_EQ(read.tree.nodes.size(), 3U);
  EXPECT_EQ(read.tree.nodes[2].parent, 1);
  EXPECT_DOUBLE_EQ(read.tree.nodes[2].start_radius_m, 0.02);
  EXPECT_EQ(read.tree.nodes[2].order, 0);
}

TEST(Mtg, PartsInAColumnOfTheirOwnAreStillParts) {
  // Nothing but the column tells that A2 follows A1; it grows out of A1's last part all the same.
  const auto read = imported(mtg("/P1\n|/A1|||0|0|0|50\n||/S1||0|0|100|40\n||^<S2||0|0|150|40\n|^<A2\n||/S1||0|0|200|30\n"));
  ASSERT_EQ(read.tree.nodes.size(), 4U);
  EXPECT_EQ(read.tree.nodes[3].parent, 2);
  EXPECT_DOUBLE_EQ(read.tree.nodes[3].start_radius_m, 0.02);
}

TEST(Mtg, DoubleSignStandsForTheEntitiesBetween) {
  const auto read = imported(mtg("/P1\n|/A1|||0|0|0|50\n|^/S1<<S12|||0|0|120|40\n"));
  EXPECT_EQ(read.elements, 14U);
  EXPECT_EQ(read.placed_elements, 2U);
  ASSERT_EQ(read.tree.nodes.size(), 2U);
  EXPECT_NEAR(read.tree.nodes[1].position_m.z, 1.2, 1e-12);
  refused(mtg("/P1\n|/A1|||0|0|0|50\n|^/S9<<S3|||0|0|120|40\n"), "'<<' must lead from");
  refused(mtg("/P1\n|/A1|||0|0|0|50\n|^/S2<<A3|||0|0|120|40\n"), "'<<' must lead from");
}

TEST(Mtg, ElementsOfNoLengthAreJoinedWithTheirBearer) {
  const auto read = imported(mtg(
      "/P1\n|/A1|||0|0|0|50\n|^/S1|||0|0|10|40\n|^<S2|||0|0|10|38\n||+A2||3|0|10|9\n||^/S1||3|0|10|9\n|^<S3|||0|0|20|30\n"));
  EXPECT_EQ(noted(read, "no length"), 2U);
  ASSERT_EQ(read.tree.nodes.size(), 4U);
  EXPECT_EQ(read.tree.nodes[2].parent, 1);
  EXPECT_EQ(read.tree.nodes[3].parent, 1);
  EXPECT_DOUBLE_EQ(read.tree.nodes[3].start_radius_m, 0.019);  // of S2, the last measured there
}

TEST(Mtg, MissingPositionsAreLeftOutUnlessSomethingBranchesOff) {
  const auto read = imported(
      mtg("/P1\n|/A1|||0|0|0|50\n|^/S1||||||40\n|^<S2||||||40\n||+A2/S1||50|0|20|9\n|^<S3|||0|0|90|30\n|^<S4||||||\n"));
  EXPECT_EQ(noted(read, "placed between"), 1U);
  EXPECT_EQ(noted(read, "left out"), 2U);
  ASSERT_EQ(read.tree.nodes.size(), 4U);
  expect_point(read.tree.nodes[1].position_m, {0, 0, 0.6});  // S2, two thirds of the way from the base to S3
  expect_point(read.tree.nodes[3].position_m, {0, 0, 0.9});
  EXPECT_EQ(read.tree.nodes[2].order, 1);
  EXPECT_EQ(read.tree.nodes[3].order, 0);
  EXPECT_EQ(noted(imported(mtg("/P1\n|/A1|||0|0|0|50\n|^/S1|||0|0||40\n|^<S2|||0|0|9|40\n")), "one or two coordinates"), 1U);
}

TEST(Mtg, MissingDiametersFollowFromWhatIsBorne) {
  const auto read =
      imported(mtg("/P1\n|/A1|||0|0|0|\n|^/S1|||0|0|10|\n||+A2||1|0|10|30\n||^/S1||50|0|10|30\n|^<S2|||0|0|60|40\n"
                   "|^<S3|||0|0|70|0\n"));
  EXPECT_EQ(noted(read, "zero or less"), 1U);
  EXPECT_EQ(noted(read, "thick as what they bear"), 2U);
  EXPECT_EQ(noted(read, "tips without"), 1U);
  ASSERT_EQ(read.tree.nodes.size(), 6U);
  EXPECT_NEAR(read.tree.nodes[1].end_radius_m, 0.025, 1e-12);  // 15 mm and 20 mm make 25 mm
  EXPECT_NEAR(read.tree.nodes[1].start_radius_m, 0.025, 1e-12);
  EXPECT_NEAR(read.tree.nodes[5].end_radius_m, 0.002, 1e-12);
  EXPECT_NEAR(read.tree.nodes[5].start_radius_m, 0.02, 1e-12);
}

TEST(Mtg, MissingDiameterIsNeverMoreThanTheBearers) {
  const auto read =
      imported(mtg("/P1\n|/A1|||0|0|0|20\n|^/S1|||0|0|10|20\n|^<S2|||0|0|20|\n||+A2/S1||9|0|20|30\n|^<S3|||0|0|30|16\n"));
  EXPECT_DOUBLE_EQ(read.tree.nodes[2].end_radius_m, 0.01);
}

TEST(Mtg, LabelsUsedTwiceAreCountedAndASecondSuccessorIsABranch) {
  const auto twice = imported(mtg("/P1\n|/A1|||0|0|0|50\n|^/S1|||0|0|10|40\n|^<S1|||0|0|20|40\n|^<S1|||0|0|30|40\n"));
  EXPECT_EQ(noted(twice, "labels used twice"), 2U);
  EXPECT_EQ(twice.tree.nodes.size(), 4U);
  const auto second =
      imported(mtg("/P1\n|/A1|||0|0|0|50\n|^/S1|||0|0|10|40\n||<S2||0|0|20|40\n||^<S3||0|0|25|40\n|^<S4|||5|0|20|40\n"));
  EXPECT_EQ(noted(second, "second successors"), 1U);
  EXPECT_EQ(second.tree.nodes.back().parent, 1);
  EXPECT_EQ(second.tree.nodes.back().order, 1);
}

TEST(Mtg, LoopIsRefusedWithBothLines) {
  refused(mtg("/P1\n|/A1|||0|0|0|50\n|^/S1|||0|0|10|40\n|^<S2|||0|0|20|40\n|^<S1|||0|0|10|40\n"),
          "test.mtg:29: S1 comes back to itself (line 27): a loop");
}

TEST(Mtg, OnlyTheFirstPlantIsRead) {
  const auto read = imported(mtg(std::string(kFork) + "/P2\n|/A1|||0|0|0|50\n"));
  EXPECT_EQ(read.tree.nodes.size(), 5U);
  EXPECT_EQ(noted(read, "further plants"), 1U);
}

TEST(Mtg, WindowsLineEndsCommentsAndBlanksDoNotMatter) {
  std::string text = mtg(kFork);
  std::string windows = "# a walnut\r\n";
  for (const char c : text) windows += c == '\n' ? std::string(" # x\r\n\r\n") : std::string(1, c);
  EXPECT_EQ(imported(windows).tree.nodes.size(), 5U);
}

TEST(Mtg, BrokenTextIsRefusedWithItsLine) {
  const std::string root = "/P1\n|/A1|||0|0|0|50\n";
  refused("", "says nowhere CODE: FORM-A");
  refused("hello\n", "test.mtg:1: is not MTG text");
  refused("CODE:\tFORM-B\n", "test.mtg:1: CODE: FORM-B: only FORM-A");
  refused("CODE:\tFORM-A\nGARDEN:\n", "test.mtg:2: unknown section 'GARDEN'");
  refused("CODE:\tFORM-A\nCLASSES:\nP\tone\n", "test.mtg:3: class P: the scale");
  refused("CODE:\tFORM-A\nDESCRIPTION:\nS\tS\t%\t1\n", "test.mtg:3: DESCRIPTION: unknown relation '%'");
  refused("CODE:\tFORM-A\nMTG:\n", "lists no classes");
  refused(mtg(""), "holds no entity");
  refused(mtg("", "XX\tYY\n"), "must name the columns");
  refused(mtg(root, "ENTITY-CODE\t\t\t\tXX\tYY\n"), "no columns XX, YY and ZZ");
  refused(mtg(root + "|^/S1|||0|zero|10|40\n"), "test.mtg:27: YY: 'zero' is no number");
  refused(mtg(root + "|^/S1|||0|inf|10|40\n"), "test.mtg:27: YY: 'inf' is no number");
  refused(mtg(root + "|^%S1|||0|0|10|40\n"), "test.mtg:27: unknown relation '%'");
  refused(mtg(root + "|S1|||0|0|10|40\n"), "test.mtg:27: unknown relation 'S'");
  refused(mtg(root + "|^/Q1|||0|0|10|40\n"), "test.mtg:27: unknown class 'Q'");
  refused(mtg(root + "|^/S99999999999|||0|0|10|40\n"), "test.mtg:27: an index above");
  refused(mtg(root + "|^\n"), "'^' without an entity");
  refused(mtg(root + "|||/S1|0|0|10|40\n"), "test.mtg:27: no entity stands one column to the left");
  refused(mtg(root + "||^/S1||0|0|10|40\n"), "test.mtg:27: '^' goes on from an entity of its own column");
  refused(mtg(root + "|^/S1|||0|0|10|40\n||+A2\n|^<S2|||0|0|20|40\n||^/S1||5|0|10|40\n"), "test.mtg:30: '^' goes on");
  refused(mtg(root + "||||0|0|10|40\n"), "test.mtg:27: features without an entity");
  refused(mtg(root + "|*3|||0|0|10|40\n"), "dates");
  refused(mtg("<P1\n"), "begins with '/'");
  refused(mtg("^/P1\n"), "'^' goes on from an entity of its own column");
}

TEST(Mtg, TreesThatAreNoneAreRefused) {
  refused(mtg("/P1\n|/A1|||0|0|0|50\n"), "a single point");
  refused(mtg("/P1\n|/A1|||0|0|0|50\n|^/S1|||0|0|0|40\n"), "a single point");
  refused(mtg("/P1\n|/A1\n|^/S1\n"), "no element has a position");
  refused(mtg("/P1\n|/A1|||0|0|0|50\n|^/S1|||0|0|90000|40\n"), "test.mtg:27: S1 is 900 m from the foot");
  refused(mtg("/P1\n|/A1|||0|0|0|50\n|^/S1|||0|0|1e300|40\n"), "from the foot");
  refused(mtg("/P1\n|/A1|||0|0|0|50\n|^/S1|||0|0|90|90000\n"), "S1 is 90 m thick");
  refused(mtg(kFork), "must be positive", {.length_unit_m = 0});
}

TEST(Mtg, DressingFileSaysTheUnits) {
  MtgOptions options{.length_unit_m = 0.01, .diameter_unit_m = 7};
  ASSERT_TRUE(
      apply_dressing("# walnut\r\n\r\nSMBPath = ../x\r\nDiameterUnit = 10\t\r\nLengthUnit = 2 # half\r\n", "w.drf", options));
  EXPECT_DOUBLE_EQ(options.diameter_unit_m, 0.001);
  EXPECT_DOUBLE_EQ(options.length_unit_m, 0.005);
  const auto wrong = apply_dressing("\nDiameterUnit = -3\n", "w.drf", options);
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message, HasSubstr("w.drf:2: DiameterUnit must be a positive number"));
}

TEST(Mtg, DigitisedWalnutIsReadWhole) {
  ROSEAU_REQUIRE_DATA(path, "data/mtg_walnut/noylum2.mtg");
  ROSEAU_REQUIRE_DATA(dressing, "data/mtg_walnut/noyer.drf");
  MtgOptions options;
  ASSERT_TRUE(apply_dressing(file_text(dressing), "noyer.drf", options));
  EXPECT_DOUBLE_EQ(options.diameter_unit_m, 0.001);
  const auto read = imported(file_text(path), options);
  EXPECT_EQ(read.elements, 8303U);         // 1 plant, 1875 axes, 2999 S, 3428 U
  EXPECT_EQ(read.placed_elements, 8301U);  // as its SOURCE.txt says
  EXPECT_EQ(noted(read, "no length"), 276U);
  EXPECT_EQ(read.tree.nodes.size(), 8301U - 276U);
  EXPECT_EQ(noted(read, "without a position"), 1U);
  EXPECT_EQ(noted(read, "without a diameter"), 0U);
  const auto figures = statistics(read.tree);
  EXPECT_NEAR(figures.height_m, 7.68 + 0.2723, 0.005);
  EXPECT_NEAR(figures.extent_east_m, 6.4, 0.05);
  EXPECT_NEAR(figures.extent_north_m, 5.6, 0.05);
  EXPECT_DOUBLE_EQ(figures.foot_radius_m, 0.135);
  EXPECT_NEAR(figures.radius_at_1_3_m, 0.096, 0.002);  // 18 cm thick at 1.2 m above the origin of the measurement
  EXPECT_EQ(figures.leaves, 6837U);
  expect_point(read.foot_in_source_m, {-0.0345, -0.2107, -0.2723});
}

TEST(Mtg, DigitisedAppleTreeIsRead) {
  ROSEAU_REQUIRE_DATA(path, "data/mtg_walnut/agraf.mtg");
  // Millimetres and tenths of them; NFe does not count leaves here.
  const auto read = imported(file_text(path), {.length_unit_m = 0.001, .diameter_unit_m = 0.0001, .leaf_count_column = ""});
  const auto figures = statistics(read.tree);
  EXPECT_GT(figures.nodes, 800U);
  EXPECT_NEAR(figures.height_m, 2.809, 0.001);
  EXPECT_NEAR(figures.foot_radius_m, 0.01875, 1e-6);
  EXPECT_GT(noted(read, "placed between"), 50U);
  EXPECT_GT(noted(read, "no length"), 10U);
}

TEST(Mtg, MeasuredTreeWithoutCoordinatesIsRefused) {
  ROSEAU_REQUIRE_DATA(path, "data/mtg_walnut/wij10.mtg");
  refused(file_text(path), "was not digitised in space");
}

}  // namespace
}  // namespace roseau::structure
