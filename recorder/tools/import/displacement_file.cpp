#include "recorder/tools/import/displacement_file.h"

#include <fmt/format.h>

#include <cmath>

namespace roseau::recorder {

namespace {

const ColumnRequest kX{"x", {"x", "dx", "displacement", "displacement_x", "x_m", "x_px", "strain"}};
const ColumnRequest kY{"y", {"y", "dy", "displacement_y", "y_m", "y_px"}};
const ColumnRequest kTime{"time", {"timestamp", "datetime", "date_time", "time"}};

const std::vector<std::string> kQuantities = {"x", "y", "time"};

struct Columns {
  std::size_t x = 0;
  std::optional<std::size_t> y;
  std::optional<std::size_t> time;
};

bool is_unnamed(const TableHead& head) { return head.columns.front() == "1"; }

Result<Columns> find_columns(const TableHead& head, const std::map<std::string, std::string>& map) {
  Columns columns;
  const auto time = find_column(head, kTime, map);
  if (!time) return time.error();
  columns.time = *time;
  if (map.empty() && (head.columns.size() == 1 || (head.columns.size() == 2 && is_unnamed(head)))) {
    if (head.columns.size() == 2) columns.y = 1;
    return columns;
  }
  const auto x = require_column(head, kX, map);
  if (!x) return x.error();
  columns.x = *x;
  const auto y = find_column(head, kY, map);
  if (!y) return y.error();
  columns.y = *y;
  return columns;
}

Result<Displacement> read_sample(const TableRows& rows, const Columns& columns, const Displacement& before) {
  Displacement sample = before;
  sample.valid = true;
  const auto x = rows.number(columns.x);
  if (!x) return x.error();
  double y_value = 0;
  if (columns.y) {
    const auto y = rows.number(*columns.y);
    if (!y) return y.error();
    y_value = *y;
  }
  if (std::isfinite(*x) && std::isfinite(y_value)) {
    sample.x = *x;
    sample.y = y_value;
  } else {
    sample.valid = false;
  }
  sample.health = sample.valid ? 1.0F : 0.0F;
  return sample;
}

}  // namespace

Result<LengthUnit> length_unit_from_string(std::string_view name) {
  for (const auto unit : {LengthUnit::pixel, LengthUnit::metre, LengthUnit::strain, LengthUnit::other}) {
    if (to_string(unit) == name) return unit;
  }
  return Error{ErrorCode::invalid_argument, fmt::format("unit '{}' is not known: px, m, strain, other", name)};
}

Result<DisplacementRecord> parse_displacement_file(std::string_view text, const std::string& source_name,
                                                   const DisplacementFileOptions& options) {
  const auto map = parse_column_map(options.columns, kQuantities);
  if (!map) return map.error();
  const auto head = read_table_head(text, source_name, options.format);
  if (!head) return head.error();
  const auto columns = find_columns(*head, *map);
  if (!columns) return columns.error();

  DisplacementRecord record{.has_two_axes = columns->y.has_value()};
  std::vector<Duration> stamps;
  Displacement before{.unit = options.unit};
  TableRows rows(*head);
  for (auto more = rows.next(); !more || *more; more = rows.next()) {
    if (!more) return more.error();
    const auto sample = read_sample(rows, *columns, before);
    if (!sample) return sample.error();
    before = *sample;
    record.samples.push_back(before);
    if (!before.valid) ++record.invalid_samples;
    if (!columns->time) continue;
    const auto stamp = parse_time_stamp(rows.fields()[*columns->time]);
    if (!stamp) {
      return Error{ErrorCode::corrupt, fmt::format("{}:{}: column '{}': '{}' is no time", source_name, rows.line(),
                                                   head->columns[*columns->time], rows.fields()[*columns->time])};
    }
    stamps.push_back(*stamp);
  }
  if (rows.was_cut()) record.remarks.push_back("the last line is cut short and was left out");
  if (record.samples.empty()) return Error{ErrorCode::corrupt, source_name + ": no rows"};
  auto times = place_records(record.samples.size(), stamps, options.rate_hz, source_name);
  if (!times) return times.error();
  record.times = std::move(*times);
  if (record.times.missing_rows > 0)
    record.remarks.push_back(fmt::format("by its times {} rows are missing", record.times.missing_rows));
  if (!stamps.empty()) record.begin = stamps.front();
  return record;
}

}  // namespace roseau::recorder
