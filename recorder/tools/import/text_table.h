// Tables of numbers in text files: CSV of any dialect, Campbell's TOA5, plain columns. Pure.
//
// The separator is found (comma, semicolon, tab, else blanks); with semicolons a comma inside a number is its decimal point.
// A first line without any number names the columns, and lines without numbers right below it are units and the like.
// Without names, columns are called 1, 2, 3, ...
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace roseau::recorder {

enum class TableFormat : std::uint8_t {
  automatic,  // TOA5 if its first line says so, else CSV
  csv,
  toa5,
};
Result<TableFormat> table_format_from_string(std::string_view name);

/// What is known of a table before its first row of numbers.
struct TableHead {
  std::string source_name;           // for messages: the file's name
  std::vector<std::string> columns;  // names
  std::vector<std::string> units;    // one per column where the file tells, else empty
  char separator = ',';              // ' ': any number of blanks
  std::string_view rows;             // the text from the first row on
  std::size_t first_line = 1;        // number of that row's line in the file

  /// "a, b, c": for messages.
  std::string column_list() const;
};

/// `text` must outlive what is returned.
Result<TableHead> read_table_head(std::string_view text, std::string source_name, TableFormat format);

/// One field of a row.
struct Cell {
  enum class Kind : std::uint8_t { number, missing, text };
  Kind kind = Kind::missing;
  double number = 0;
};

/// Missing values: empty, NAN, NA, NULL, INF of either case, and the numbers -9999 and +-7999 (Campbell: out of range).
Cell parse_cell(std::string_view text, char separator);

/// Goes through the rows of a table.
class TableRows {
 public:
  explicit TableRows(const TableHead& head) : head_(head), rest_(head.rows), line_(head.first_line) {}

  /// False at the end. Error: a row whose number of fields is not that of the columns. Empty lines are passed over. A last
  /// line without its end may be cut short: it is left out, and was_cut() says so.
  Result<bool> next();

  const std::vector<std::string_view>& fields() const { return fields_; }
  std::size_t line() const { return line_ - 1; }
  bool was_cut() const { return was_cut_; }

  /// The number in a column of the current row; NaN if it is missing. Error: no number, naming file, line and column.
  Result<double> number(std::size_t column) const;

 private:
  const TableHead& head_;
  std::string_view rest_;
  std::size_t line_;  // of the line to come
  std::vector<std::string_view> fields_;
  bool was_cut_ = false;
};

/// "u=U,v=V": which column serves for what. Error: not of this form, a quantity that is none of `known`, or one twice.
Result<std::map<std::string, std::string>> parse_column_map(std::string_view text, const std::vector<std::string>& known);

/// A quantity we look for, and the names that columns of it go by, as normalised_name makes them.
struct ColumnRequest {
  std::string quantity;
  std::vector<std::string> usual_names;
};

/// Lower case, without blanks and without a unit in brackets: "U (m/s)" -> "u".
std::string normalised_name(std::string_view name);

/// The column for a quantity: the one given in `map`, else the first of the usual names that the table has; nothing if there is
/// none. Error: the given one does not exist.
Result<std::optional<std::size_t>> find_column(const TableHead& head, const ColumnRequest& request,
                                               const std::map<std::string, std::string>& map);

/// As find_column; Error also if there is none.
Result<std::size_t> require_column(const TableHead& head, const ColumnRequest& request,
                                   const std::map<std::string, std::string>& map);

}  // namespace roseau::recorder
