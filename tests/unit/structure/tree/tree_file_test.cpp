#include "structure/tree/tree_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace roseau::structure {
namespace {

using ::testing::HasSubstr;

constexpr const char* kStick =
    "CODE:\tFORM-A\nCLASSES:\nP\t1\nMTG:\nENTITY-CODE\tXX\tYY\tZZ\tTopDia\n/P1\t0\t0\t0\t20\n^<P2\t0\t0\t100\t10\n";
constexpr const char* kCylinder = "0.1 2 0 0 0 0 0 1 0\n";

TreeFileOptions dressed_by(const std::string& path) {
  TreeFileOptions options;
  options.dressing = path;
  return options;
}

TEST(TreeFile, EndingSaysHowItIsRead) {
  const testing::TemporaryFolder folder;
  const auto stick = read_tree(folder.write("stick.MTG", kStick));
  ASSERT_TRUE(stick) << stick.error().message;
  EXPECT_EQ(stick->tree.name, "stick");
  EXPECT_DOUBLE_EQ(stick->tree.nodes[1].position_m.z, 1);
  EXPECT_DOUBLE_EQ(stick->tree.nodes[1].end_radius_m, 0.005);
  const auto cylinder = read_tree(folder.write("one.csv", kCylinder));
  ASSERT_TRUE(cylinder) << cylinder.error().message;
  EXPECT_DOUBLE_EQ(cylinder->tree.nodes[1].position_m.z, 2);
}

TEST(TreeFile, DressingOfTheSameNameOrTheOneNamedGivesTheUnits) {
  const testing::TemporaryFolder folder;
  const auto path = folder.write("stick.mtg", kStick);
  folder.write("stick.drf", "DiameterUnit = 20\n");
  const auto other = folder.write("other.drf", "DiameterUnit = 5\nLengthUnit = 2\n");
  EXPECT_DOUBLE_EQ(read_tree(path)->tree.nodes[1].end_radius_m, 0.0025);
  EXPECT_DOUBLE_EQ(read_tree(path, {.look_for_dressing = false})->tree.nodes[1].end_radius_m, 0.005);
  const auto named = read_tree(path, dressed_by(other));
  EXPECT_DOUBLE_EQ(named->tree.nodes[1].end_radius_m, 0.01);
  EXPECT_DOUBLE_EQ(named->tree.nodes[1].position_m.z, 0.5);
}

TEST(TreeFile, ErrorsNameTheFile) {
  const testing::TemporaryFolder folder;
  const auto refused = [](const std::string& path, const TreeFileOptions& options, const std::string& what) {
    const auto read = read_tree(path, options);
    ASSERT_FALSE(read) << path;
    EXPECT_THAT(read.error().message, HasSubstr(what));
  };
  const auto absent = (folder.path() / "absent.mtg").string();
  refused(absent, {}, absent);
  refused(folder.path().string(), {}, "is no file");
  const auto broken = folder.write("broken.mtg", "hello\n");
  refused(broken, {}, broken + ":1");
  const auto stick = folder.write("stick.mtg", kStick);
  refused(stick, dressed_by(absent), absent);
  refused(folder.write("empty.txt", ""), {}, "empty.txt: holds no cylinder");
  refused(folder.write("empty.mat", ""), {}, "empty.mat");
}

}  // namespace
}  // namespace roseau::structure
