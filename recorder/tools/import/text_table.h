// Tables of numbers in text files: CSV of any dialect, Campbell's TOA5, the data part of LI-COR's GHG, plain columns.
//
// The separator is found (comma, semicolon, tab, else blanks); with semicolons a comma inside a number is its decimal point.
// A first line without any number names the columns, and lines without numbers right below it are units and the like.
// Without names, columns are called 1, 2, 3, ...
//
// GHG: lines of "key: value", then the names behind DATAH (units behind DATAU), then rows behind DATA, all with tabs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "recorder/tools/import/byte_source.h"
#include "recorder/tools/import/table.h"

namespace roseau::recorder {

enum class TableFormat : std::uint8_t {
  automatic,  // TOA5 or GHG if the first lines say so, else CSV
  csv,
  toa5,
  ghg,
};

class TextTable : public TableReader {
 public:
  /// Reads the head. Error: names the file, and what its head lacks.
  static Result<std::unique_ptr<TextTable>> open(FileReader file, TableFormat format);

  char separator() const { return separator_; }               // ' ': any number of blanks
  std::size_t first_line() const { return head_lines_ + 1; }  // number of the first row's line

  Result<void> rewind() override;
  /// Error: a row whose number of fields is not that of the columns. Empty lines are passed over. A last line without its end
  /// may be cut short: if fields are missing it is left out, and was_cut() says so.
  Result<bool> next() override;
  Result<double> number(std::size_t column) const override;
  Result<Duration> time_stamp(std::size_t column) const override;
  bool was_cut() const override { return was_cut_; }
  double share() const override { return file_.share(); }

  const std::vector<std::string_view>& fields() const { return fields_; }

 private:
  explicit TextTable(FileReader file) : file_(std::move(file)) { head_.source_name = file_.name(); }

  Result<void> read_head(TableFormat format);
  Result<void> skip_byte_order_mark();
  Result<void> read_toa5_head();
  Result<void> read_ghg_head();
  Result<void> read_csv_head();
  std::string where(std::size_t column) const;

  FileReader file_;
  char separator_ = ',';
  std::size_t head_lines_ = 0;
  std::vector<std::string_view> fields_;
  bool was_cut_ = false;
};

/// One field of a row.
struct Cell {
  enum class Kind : std::uint8_t { number, missing, text };
  Kind kind = Kind::missing;
  double number = 0;
};

/// Missing values: empty, NAN, NA, NULL, INF of either case, and the numbers -9999 and +-7999 (Campbell: out of range).
Cell parse_cell(std::string_view text, char separator);

/// Takes a line's fields apart: quotes and blanks around them are taken off.
void split_fields(std::string_view line, char separator, std::vector<std::string_view>& fields);

/// Without blanks at its ends.
std::string_view trimmed(std::string_view text);

std::string in_lower_case(std::string_view text);

}  // namespace roseau::recorder
