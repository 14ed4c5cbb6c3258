#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/toml/table.h"

namespace roseau {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(TomlTable, ReadsEveryType) {
  auto root =
      TomlTable::parse("a = 1\nb = 2.5\nc = 'x'\nd = true\ne = [1, 2.5]\n[f]\ng = 3\n[[h]]\ni = 4\n[[h]]\ni = 5\n", "t.toml");
  ASSERT_TRUE(root);
  EXPECT_EQ(root->number("a", 0), 1);
  EXPECT_EQ(root->number("b", 0), 2.5);
  EXPECT_EQ(root->text("c", ""), "x");
  EXPECT_TRUE(root->boolean("d", false));
  EXPECT_THAT(root->numbers("e"), ElementsAre(1, 2.5));
  EXPECT_EQ(root->table("f").integer("g", 0), 3);
  auto list = root->tables("h");
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0].integer("i", 0), 4);
  EXPECT_EQ(list[1].integer("i", 0), 5);
  EXPECT_TRUE(root->finish());
}

TEST(TomlTable, AbsentKeysGiveFallbacks) {
  auto root = TomlTable::parse("", "t.toml");
  EXPECT_EQ(root->number("a", 7), 7);
  EXPECT_EQ(root->table("b").text("c", "d"), "d");
  EXPECT_TRUE(root->tables("e").empty());
  EXPECT_TRUE(root->finish());
}

TEST(TomlTable, UnknownKeyIsAnErrorWithItsLineAndTheKnownOnes) {
  auto root = TomlTable::parse("port = 1\n[sonic]\nbuad = 9600\n", "t.toml");
  root->integer("port", 0);
  root->table("sonic").integer("baud", 0);
  const auto finished = root->finish();
  ASSERT_FALSE(finished);
  EXPECT_THAT(finished.error().message, HasSubstr("t.toml:3: unknown key 'buad'"));
  EXPECT_THAT(finished.error().message, HasSubstr("baud"));
}

TEST(TomlTable, WrongTypeMissingAndComplaintsNameTheLine) {
  auto root = TomlTable::parse("a = 'x'\n", "t.toml");
  root->number("a", 0);
  EXPECT_THAT(root->finish().error().message, HasSubstr("t.toml:1: 'a' must be a number"));

  root = TomlTable::parse("[s]\nb = -1\n", "t.toml");
  auto table = root->table("s");
  if (table.number("b", 0) < 0) table.complain("b", "must be positive");
  EXPECT_THAT(root->finish().error().message, HasSubstr("t.toml:2: 's.b' must be positive"));

  root = TomlTable::parse("[s]\n", "t.toml");
  table = root->table("s");
  table.required_text("path");
  EXPECT_THAT(root->finish().error().message, HasSubstr("'s.path' is missing"));
}

TEST(TomlTable, SyntaxErrorNamesTheLine) {
  const auto root = TomlTable::parse("a = 1\nb = [\n", "t.toml");
  ASSERT_FALSE(root);
  EXPECT_THAT(root.error().message, HasSubstr("t.toml:"));
}

}  // namespace
}  // namespace roseau
