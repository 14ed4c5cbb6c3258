#include "structure/tree/qsm.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <matio.h>

#include <array>
#include <fstream>

#include "structure/tree/statistics.h"
#include "structure/tree/vector3.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

namespace roseau::structure {
namespace {

using ::testing::HasSubstr;

// Radius, length, start, axis, parent: a trunk of two cylinders, foot at (10, 20, 30).
const std::string kTrunk =
    "0.1 2 10 20 30 0 0 1 0\n"
    "0.08 2 10 20 32 0 0 1 1\n";

ImportedTree imported(const std::string& text) {
  auto tree = read_qsm_text(text, "table.txt");
  EXPECT_TRUE(tree) << tree.error().message;
  return tree ? std::move(*tree) : ImportedTree{};
}

std::size_t noted(const ImportedTree& tree, const std::string& what) {
  for (const auto& note : tree.notes) {
    if (note.what.find(what) != std::string::npos) return note.count;
  }
  return 0;
}

void refused(const std::string& text, const std::string& what) {
  const auto tree = read_qsm_text(text, "table.txt");
  ASSERT_FALSE(tree) << what;
  EXPECT_THAT(tree.error().message, HasSubstr(what));
}

void expect_point(const Vec3& found, const Vec3& expected) {
  EXPECT_NEAR(distance(found, expected), 0, 1e-9) << found.x << ' ' << found.y << ' ' << found.z;
}

TEST(Qsm, BranchSplitsItsParentWhereItBegins) {
  const auto read = imported("# made by hand\n" + kTrunk + "0.02,1.5,10,20,31.2,1,0,0,1\n");
  const auto& nodes = read.tree.nodes;
  ASSERT_EQ(nodes.size(), 5U);
  expect_point(read.foot_in_source_m, {10, 20, 30});
  expect_point(nodes[1].position_m, {0, 0, 1.2});
  expect_point(nodes[2].position_m, {0, 0, 2});
  expect_point(nodes[3].position_m, {0, 0, 4});
  expect_point(nodes[4].position_m, {1.5, 0, 1.2});
  EXPECT_EQ(nodes[4].parent, 1);
  EXPECT_DOUBLE_EQ(nodes[1].start_radius_m, 0.1);
  EXPECT_DOUBLE_EQ(nodes[2].end_radius_m, 0.1);
  EXPECT_DOUBLE_EQ(nodes[3].start_radius_m, 0.08);
  EXPECT_DOUBLE_EQ(nodes[4].end_radius_m, 0.02);
  EXPECT_EQ(noted(read, "no branch orders"), 1U);
  EXPECT_EQ(nodes[3].order, 0);
  EXPECT_EQ(nodes[4].order, 1);
}

TEST(Qsm, BranchNearAnEndUsesThatEndAndBranchesNearEachOtherShareAPoint) {
  const auto read = imported(kTrunk + "0.02 1 10 20 31.97 1 0 0 1\n0.02 1 10 20 31 0 1 0 1\n0.02 1 10 20 31.02 0 -1 0 1\n");
  EXPECT_EQ(read.tree.nodes.size(), 3U + 1U + 3U);
  EXPECT_EQ(read.tree.nodes[4].parent, 2);  // the branch at 31.97 on the trunk's second node, at 32
  EXPECT_EQ(read.tree.nodes[5].parent, 1);
  EXPECT_EQ(read.tree.nodes[6].parent, 1);
}

TEST(Qsm, GapsAreStretchedWhereSmallAndBridgedWhereLarge) {
  const auto read = imported(kTrunk + "0.02 1 10.09 20 31 1 0 0 1\n0.02 1 10.5 20 33 1 0 0 2\n");
  EXPECT_EQ(noted(read, "stretched"), 1U);
  EXPECT_EQ(noted(read, "bridged"), 1U);
  const auto& nodes = read.tree.nodes;
  ASSERT_EQ(nodes.size(), 8U);
  expect_point(nodes[5].position_m, {1.09, 0, 1});  // from the axis straight to its end
  expect_point(nodes[6].position_m, {0.5, 0, 3});   // the bridge ends where the cylinder begins
  expect_point(nodes[7].position_m, {1.5, 0, 3});
}

TEST(Qsm, OnlyTheDirectionOfAnAxisCounts) {
  const auto read = imported("0.1 2 0 0 0 0 0 25 0\n");
  expect_point(read.tree.nodes[1].position_m, {0, 0, 2});
  EXPECT_EQ(noted(read, "only the direction"), 1U);
}

TEST(Qsm, CylinderWithoutLengthIsLeftOutAndItsBranchesHangOnItsParent) {
  const auto read = imported(kTrunk + "0.05 0 10 20 34 0 0 1 2\n0.04 1 10 20 34 0 0 1 3\n");
  EXPECT_EQ(noted(read, "no length"), 1U);
  ASSERT_EQ(read.tree.nodes.size(), 4U);
  EXPECT_EQ(read.tree.nodes[3].parent, 2);
  EXPECT_EQ(read.placed_elements, 3U);
}

TEST(Qsm, RowsMayComeInAnyOrderAndOrdersAreTakenFromTheTable) {
  const auto read = imported("0.05 1 0 0 2 0 0 1 2 0 1 3 1 0\n0.1 2 0 0 0 0 0 1 0 0 1 0 1 0\n");
  ASSERT_EQ(read.tree.nodes.size(), 3U);
  EXPECT_EQ(read.tree.nodes[2].order, 3);
  EXPECT_TRUE(read.notes.empty());
}

TEST(Qsm, BrokenTablesAreRefusedWithTheirRow) {
  refused("", "holds no cylinder");
  refused("1 2 3\n", "has 3 columns");
  refused(kTrunk + "0.02 1 10\n", "table.txt:3: has 3 numbers, the rows before have 9");
  refused(kTrunk + "0.02 1 10 20 31.5 1 0 zero 1\n", "table.txt:3: is no row of numbers");
  refused(kTrunk + "0.02 1 10 20 31.5 1 0 0x1 1\n", "table.txt:3: is no row of numbers");
  refused(kTrunk + "0.02 nan 10 20 31.5 1 0 0 1\n", "table.txt:3: column 2 is not finite");
  refused(kTrunk + "0 1 10 20 31.5 1 0 0 1\n", "table.txt:3: the radius is not positive");
  refused(kTrunk + "0.02 1 10 20 31.5 1 0 0 9\n", "table.txt:3: parent 9 is no row");
  refused(kTrunk + "0.02 1 10 20 31.5 1 0 0 1.5\n", "table.txt:3: parent 1.5 is no row");
  refused(kTrunk + "0.02 1 10 20 31.5 1 0 0 0\n", "table.txt:3: has no parent, like row 1");
  refused(kTrunk + "0.02 1 10 20 31.5 1 0 0 4\n0.02 1 10 20 31.5 1 0 0 3\n", "table.txt:3: its parents form a loop");
  refused(kTrunk + "0.02 1 10 20 31.5 1 0 0 3\n", "table.txt:3: its parents form a loop");
  refused("0.1 2 0 0 0 0 0 1 1\n", "a loop");
  refused("0.1 0 0 0 0 0 0 1 0\n", "the lowest cylinder has no length");
  refused("0.1 2000 0 0 0 0 0 1 0\n", "are these metres?");
}

void write_mat(const std::filesystem::path& path, matio_types type, matio_classes kind, const void* data,
               std::array<std::size_t, 2> size, mat_ft format = MAT_FT_MAT5) {
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, format);
  ASSERT_NE(file, nullptr);
  matvar_t* variable = Mat_VarCreate("cylinders", kind, type, 2, size.data(), const_cast<void*>(data), MAT_F_DONT_COPY_DATA);
  EXPECT_EQ(Mat_VarWrite(file, variable, MAT_COMPRESSION_ZLIB), 0);
  Mat_VarFree(variable);
  Mat_Close(file);
}

TEST(Qsm, MatlabFilesOfEitherPrecisionAndVersionReadLikeText) {
  const testing::TemporaryFolder folder;
  const std::array<double, 18> doubles{0.1, 0.08, 2, 2, 10, 10, 20, 20, 30, 32, 0, 0, 0, 0, 1, 1, 0, 1};
  std::array<float, 18> floats{};
  std::copy(doubles.begin(), doubles.end(), floats.begin());
  write_mat(folder.path() / "double.mat", MAT_T_DOUBLE, MAT_C_DOUBLE, doubles.data(), {2, 9});
  write_mat(folder.path() / "single.mat", MAT_T_SINGLE, MAT_C_SINGLE, floats.data(), {2, 9});
  write_mat(folder.path() / "hdf5.mat", MAT_T_DOUBLE, MAT_C_DOUBLE, doubles.data(), {2, 9}, MAT_FT_MAT73);
  const auto text = imported(kTrunk);
  for (const char* name : {"double.mat", "single.mat", "hdf5.mat"}) {
    const auto read = read_qsm_mat(folder.path() / name);
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->tree.nodes.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(distance(read->tree.nodes[i].position_m, text.tree.nodes[i].position_m), 0, 1e-6);
    }
  }
}

TEST(Qsm, MatlabFilesThatHoldNoCylindersAreRefused) {
  const testing::TemporaryFolder folder;
  const auto refused_file = [](const std::filesystem::path& path, const char* what) {
    const auto read = read_qsm_mat(path);
    ASSERT_FALSE(read);
    EXPECT_THAT(read.error().message, HasSubstr(what));
    EXPECT_THAT(read.error().message, HasSubstr(path.filename().string()));
  };
  refused_file(folder.path() / "absent.mat", "is no file");
  std::ofstream(folder.path() / "text.mat") << "hello";
  refused_file(folder.path() / "text.mat", "MATLAB");
  const std::array<double, 6> small{};
  write_mat(folder.path() / "small.mat", MAT_T_DOUBLE, MAT_C_DOUBLE, small.data(), {2, 3});
  refused_file(folder.path() / "small.mat", "no matrix of at least 9 columns");
  const std::array<double, 18> doubles{0.1, 0.08, 2, 2, 10, 10, 20, 20, 30, 32, 0, 0, 0, 0, 1, 1, 0, 1};
  write_mat(folder.path() / "cut.mat", MAT_T_DOUBLE, MAT_C_DOUBLE, doubles.data(), {2, 9});
  std::filesystem::resize_file(folder.path() / "cut.mat", std::filesystem::file_size(folder.path() / "cut.mat") - 20);
  EXPECT_FALSE(read_qsm_mat(folder.path() / "cut.mat"));
}

TEST(Qsm, AllTwentyOneScannedTreesAreRead) {
  ROSEAU_REQUIRE_DATA(folder, "data/tree_qsm_wytham");
  int trees = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().filename().string().rfind("cyl_data", 0) != 0) continue;
    ++trees;
    const auto read = read_qsm_mat(entry.path());
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->placed_elements, read->elements);
    const auto figures = statistics(read->tree);
    EXPECT_GE(figures.nodes, read->elements + 1);
    EXPECT_LT(figures.nodes, 2 * read->elements);
    EXPECT_GT(figures.height_m, 12);
    EXPECT_LT(figures.height_m, 26);
    EXPECT_GT(figures.radius_at_1_3_m, 0.05);
    EXPECT_LT(figures.radius_at_1_3_m, 0.4);
    EXPECT_GT(noted(*read, "only the direction"), 10U);
  }
  EXPECT_EQ(trees, 21);
}

TEST(Qsm, ScannedTreeFourteenAgreesWithItsTable) {
  ROSEAU_REQUIRE_DATA(path, "data/tree_qsm_wytham/cyl_data_Tf14_Validation_1_1.mat");
  const auto read = read_qsm_mat(path);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->elements, 1364U);
  EXPECT_NEAR(read->foot_in_source_m.x, 34.4325, 1e-3);
  EXPECT_NEAR(read->foot_in_source_m.z, -26.9746, 1e-3);
  const auto figures = statistics(read->tree);
  EXPECT_NEAR(figures.height_m, 24.44, 0.01);
  EXPECT_NEAR(figures.foot_radius_m, 0.1884, 1e-4);
}

TEST(Qsm, OtherMatlabDataIsRefused) {
  ROSEAU_REQUIRE_DATA(path, "data/tree_qsm_wytham/Sonic_data_5min.mat");
  EXPECT_FALSE(read_qsm_mat(path));
}

}  // namespace
}  // namespace roseau::structure
