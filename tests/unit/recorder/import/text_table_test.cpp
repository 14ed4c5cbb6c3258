#include "recorder/tools/import/text_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace roseau::recorder {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Result<std::unique_ptr<TextTable>> open_table(std::string_view text, TableFormat format = TableFormat::automatic) {
  return TextTable::open(FileReader(memory_source(std::string(text)), "field.csv"), format);
}

std::unique_ptr<TextTable> table_of(std::string_view text, TableFormat format = TableFormat::automatic) {
  auto table = open_table(text, format);
  EXPECT_TRUE(table) << table.error().message;
  return table ? std::move(*table) : nullptr;
}

TableHead head_of(std::string_view text) { return table_of(text)->head(); }

std::string head_error(std::string_view text, TableFormat format = TableFormat::automatic) {
  const auto table = open_table(text, format);
  return table ? "no error" : table.error().message;
}

// All numbers of a table, row by row.
std::vector<std::vector<double>> numbers_of(std::string_view text) {
  const auto rows = table_of(text);
  std::vector<std::vector<double>> numbers;
  for (auto more = rows->next(); more && *more; more = rows->next()) {
    auto& row = numbers.emplace_back();
    for (std::size_t i = 0; i < rows->fields().size(); ++i) row.push_back(*rows->number(i));
  }
  return numbers;
}

TEST(TextTable, FindsNamesAndSeparators) {
  for (const char* text :
       {"U,V,W\n1,2,3\n", "U;V;W\n1;2;3\n", "U\tV\tW\n1\t2\t3\n", "U V  W\n 1  2 3\n", "\"U\",\"V\",\"W\"\r\n\"1\",2,3\r\n",
        "\xEF\xBB\xBFU,V,W\n1,2,3\n", "\n# a remark\nU,V,W\n1,2,3,\n"}) {
    EXPECT_THAT(head_of(text).columns, ElementsAre("U", "V", "W")) << text;
    EXPECT_THAT(numbers_of(text), ElementsAre(ElementsAre(1, 2, 3))) << text;
  }
}

TEST(TextTable, WithoutNamesColumnsAreNumbered) {
  EXPECT_THAT(head_of("1,2\n3,4\n").columns, ElementsAre("1", "2"));
  EXPECT_THAT(numbers_of("  8.4059447e-05\r\n  -5.8338311e-05\r\n"),
              ElementsAre(ElementsAre(8.4059447e-05), ElementsAre(-5.8338311e-05)));
}

TEST(TextTable, ALineOfUnitsIsNoRow) {
  const auto table = table_of("U,T\nm/s,K\n1,300\n");
  EXPECT_THAT(table->head().units, ElementsAre("m/s", "K"));
  EXPECT_EQ(table->first_line(), 3U);
  const auto missing_first = table_of("U,T\n,NAN\n1,300\n");
  EXPECT_TRUE(missing_first->head().units.empty()) << "a row of missing values is a row";
  EXPECT_EQ(missing_first->first_line(), 2U);
}

TEST(TextTable, DecimalCommas) { EXPECT_THAT(numbers_of("U;V\n1,5;-2,25\n"), ElementsAre(ElementsAre(1.5, -2.25))); }

TEST(TextTable, ReadsToa5) {
  const std::string text =
      "\"TOA5\",\"mast\",\"CR3000\",\"2113\",\"CR3000.Std.11\",\"CPU:eddy.CR3\",\"32171\",\"ts_data\"\r\n"
      "\"TIMESTAMP\",\"RECORD\",\"Ux\",\"Ts\"\r\n\"TS\",\"RN\",\"m/s\",\"C\"\r\n\"\",\"\",\"Smp\",\"Smp\"\r\n"
      "\"2019-07-30 12:00:00.05\",0,1.25,\"NAN\"\r\n";
  const auto rows = table_of(text);
  const auto& head = rows->head();
  EXPECT_EQ(head.description, "logger CR3000 'mast', table ts_data");
  EXPECT_THAT(head.columns, ElementsAre("TIMESTAMP", "RECORD", "Ux", "Ts"));
  EXPECT_THAT(head.units, ElementsAre("TS", "RN", "m/s", "C"));
  ASSERT_TRUE(*rows->next());
  EXPECT_EQ(rows->fields()[0], "2019-07-30 12:00:00.05");
  EXPECT_EQ(rows->first_line(), 5U);
  EXPECT_EQ(*rows->number(2), 1.25);
  EXPECT_TRUE(std::isnan(*rows->number(3)));
  EXPECT_FALSE(*rows->next());
}

TEST(TextTable, SaysWhatIsNoTable) {
  EXPECT_THAT(head_error(""), HasSubstr("field.csv: the file is empty"));
  EXPECT_THAT(head_error(" \n\n"), HasSubstr("the file is empty"));
  EXPECT_THAT(head_error("Dear reader,\nthis is a letter.\n"), HasSubstr("no row of numbers"));
  EXPECT_THAT(head_error("U,V\n1,2\n", TableFormat::toa5), HasSubstr("field.csv:1: no TOA5 file"));
  EXPECT_THAT(head_error("\"TOA5\",\"mast\"\n\"Ux\",\"Uy\"\n"), HasSubstr("header lines of a TOA5 file are not complete"));
}

TEST(TextTable, MissingValuesAreNoNumbers) {
  for (const char* text :
       {"", " ", "NAN", "NaN", "\"NAN\"", "-9999", "-9999.0", "-9999.000", "NA", "null", "INF", "-7999", "7999"}) {
    EXPECT_EQ(parse_cell(text, ',').kind, Cell::Kind::missing) << text;
  }
  for (const char* text : {"0", "-0.5", "+3", "1e-5", "1E+05", "-9998.9", ".5"}) {
    EXPECT_EQ(parse_cell(text, ',').kind, Cell::Kind::number) << text;
  }
  for (const char* text : {"abc", "1.2.3", "1,5", "0x10", "12:00", "1e", "--1", "infinite"}) {
    EXPECT_EQ(parse_cell(text, ',').kind, Cell::Kind::text) << text;
  }
}

TEST(TextTable, AWrongRowIsNamedByItsLine) {
  const auto rows = table_of("U,V\n1,2\n1,2,3\n");
  ASSERT_TRUE(*rows->next());
  const auto wrong = rows->next();
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message, HasSubstr("field.csv:3: 3 fields where there are 2 columns (U, V)"));
}

TEST(TextTable, AWrongFieldIsNamedByLineAndColumn) {
  const auto rows = table_of("U,V\n1,2\n\n1,two\n");
  ASSERT_TRUE(*rows->next());
  ASSERT_TRUE(*rows->next());
  const auto wrong = rows->number(1);
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().message, "field.csv:4: column 'V': 'two' is no number");
}

TEST(TextTable, ALastLineCutShortIsLeftOut) {
  const auto rows = table_of("U,V\n1,2\n3");
  EXPECT_TRUE(*rows->next());
  EXPECT_FALSE(*rows->next());
  EXPECT_TRUE(rows->was_cut());
}

TEST(ColumnMap, SaysWhatIsWrong) {
  const std::vector<std::string> known = {"u", "v"};
  const auto map = parse_column_map("u=Ux, v = Uy", known);
  ASSERT_TRUE(map);
  EXPECT_EQ(map->at("u"), "Ux");
  EXPECT_EQ(map->at("v"), "Uy");
  EXPECT_TRUE(parse_column_map("", known)->empty());
  EXPECT_THAT(parse_column_map("u", known).error().message, HasSubstr("'u' should read quantity=column; known are u, v"));
  EXPECT_THAT(parse_column_map("x=1", known).error().message, HasSubstr("'x' is not known"));
  EXPECT_THAT(parse_column_map("u=1,u=2", known).error().message, HasSubstr("'u' is given twice"));
}

TEST(ColumnMap, NamesAreComparedWithoutUnitsAndCase) {
  EXPECT_EQ(normalised_name("U (m/s)"), "u");
  EXPECT_EQ(normalised_name("T_SONIC [K]"), "t_sonic");
  EXPECT_EQ(normalised_name("Ux_(m/s)"), "ux");
}

}  // namespace
}  // namespace roseau::recorder
