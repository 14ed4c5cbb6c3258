// Tables of numbers, whatever they are stored in: text (text_table.h) or Campbell's binary (tob1.h). Read row by row, from the
// first to the last, as often as wanted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "core/time.h"

namespace roseau::recorder {

/// What is known of a table before its first row of numbers.
struct TableHead {
  std::string source_name;           // for messages: the file's name
  std::vector<std::string> columns;  // names
  std::vector<std::string> units;    // one per column where the file tells, else empty
  Duration epoch{0};                 // what a column of seconds counts from, since 1970
  std::string description;           // for people: what the head says about logger and table; may be empty

  /// "a, b, c": for messages.
  std::string column_list() const;
};

class TableReader {
 public:
  virtual ~TableReader() = default;

  const TableHead& head() const { return head_; }
  virtual Result<void> rewind() = 0;
  /// False at the end. Error: a row that is none, naming the file and the place.
  virtual Result<bool> next() = 0;
  /// The number in a column of the current row; NaN if it is missing. Error: no number, naming file, place and column.
  virtual Result<double> number(std::size_t column) const = 0;
  /// The time stamp in a column of the current row, since 1970 in the stamp's own zone.
  virtual Result<Duration> time_stamp(std::size_t column) const = 0;
  /// A last row was cut short and left out.
  virtual bool was_cut() const = 0;
  /// How much has been read, 0 to 1.
  virtual double share() const = 0;

 protected:
  TableHead head_;
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

/// Where a row's time stands: in one column, or in two of whole seconds and nanoseconds.
struct TimeColumns {
  std::size_t stamp = 0;
  std::optional<std::size_t> nanoseconds;
  std::string name;  // for people
};

/// The columns given as "time" in `map`, else seconds and nanoseconds, else one of the usual names; nothing if there are none.
Result<std::optional<TimeColumns>> find_time_columns(const TableHead& head, const std::map<std::string, std::string>& map);

/// The current row's time, since 1970 in the stamp's own zone.
Result<Duration> row_time(const TableReader& table, const TimeColumns& columns);

}  // namespace roseau::recorder
