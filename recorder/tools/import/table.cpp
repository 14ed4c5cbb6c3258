#include "recorder/tools/import/table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "recorder/tools/import/text_table.h"

namespace roseau::recorder {

std::string TableHead::column_list() const { return fmt::format("{}", fmt::join(columns, ", ")); }

Result<std::map<std::string, std::string>> parse_column_map(std::string_view text, const std::vector<std::string>& known) {
  std::map<std::string, std::string> map;
  std::vector<std::string_view> pairs;
  if (!text.empty()) split_fields(text, ',', pairs);
  for (const auto pair : pairs) {
    const auto equals = pair.find('=');
    const std::string quantity(trimmed(pair.substr(0, equals)));
    const auto column = equals == std::string_view::npos ? std::string_view() : trimmed(pair.substr(equals + 1));
    const auto complaint = [&](const std::string& what) {
      return Error{ErrorCode::invalid_argument,
                   fmt::format("columns '{}': {}; known are {}", text, what, fmt::join(known, ", "))};
    };
    if (column.empty()) return complaint(fmt::format("'{}' should read quantity=column", pair));
    if (std::ranges::find(known, quantity) == known.end()) return complaint(fmt::format("'{}' is not known", quantity));
    if (!map.emplace(quantity, column).second) return complaint(fmt::format("'{}' is given twice", quantity));
  }
  return map;
}

std::string normalised_name(std::string_view name) {
  std::string normal = in_lower_case(name.substr(0, name.find_first_of("([")));
  std::erase_if(normal, [](char c) { return c == ' '; });
  while (normal.ends_with('_')) normal.pop_back();
  // LI-COR's loggers: "Aux 1 - U (m/s)".
  if (const auto dash = normal.find('-'); normal.starts_with("aux") && dash != std::string::npos) normal.erase(0, dash + 1);
  return normal;
}

Result<std::optional<std::size_t>> find_column(const TableHead& head, const ColumnRequest& request,
                                               const std::map<std::string, std::string>& map) {
  const auto index_of = [&](const auto& predicate) -> std::optional<std::size_t> {
    const auto found = std::ranges::find_if(head.columns, predicate);
    if (found == head.columns.end()) return std::nullopt;
    return static_cast<std::size_t>(found - head.columns.begin());
  };
  if (const auto given = map.find(request.quantity); given != map.end()) {
    if (const auto column = index_of([&](const auto& name) { return name == given->second; })) return column;
    return Error{ErrorCode::not_found, fmt::format("{}: column '{}' for {} is missing; the file has: {}", head.source_name,
                                                   given->second, request.quantity, head.column_list())};
  }
  for (const auto& usual : request.usual_names) {
    if (const auto column = index_of([&](const auto& name) { return normalised_name(name) == usual; })) return column;
  }
  return std::optional<std::size_t>();
}

Result<std::size_t> require_column(const TableHead& head, const ColumnRequest& request,
                                   const std::map<std::string, std::string>& map) {
  const auto column = find_column(head, request, map);
  if (!column) return column.error();
  if (*column) return **column;
  return Error{ErrorCode::not_found,
               fmt::format("{}: no column for {} (usual names: {}); the file has: {}; say which with {}=NAME", head.source_name,
                           request.quantity, fmt::join(request.usual_names, ", "), head.column_list(), request.quantity)};
}

Result<std::optional<TimeColumns>> find_time_columns(const TableHead& head, const std::map<std::string, std::string>& map) {
  static const ColumnRequest kStamp{"time", {"timestamp", "datetime", "date_time", "time"}};
  static const ColumnRequest kSeconds{"", {"seconds"}};
  static const ColumnRequest kNanoseconds{"", {"nanoseconds"}};
  if (!map.contains("time")) {
    const auto seconds = find_column(head, kSeconds, {});
    const auto nanoseconds = find_column(head, kNanoseconds, {});
    if (seconds && nanoseconds && *seconds && *nanoseconds) {
      return std::optional(
          TimeColumns{**seconds, *nanoseconds, fmt::format("{} and {}", head.columns[**seconds], head.columns[**nanoseconds])});
    }
  }
  const auto stamp = find_column(head, kStamp, map);
  if (!stamp) return stamp.error();
  if (!*stamp) return std::optional<TimeColumns>();
  return std::optional(TimeColumns{**stamp, std::nullopt, head.columns[**stamp]});
}

Result<Duration> row_time(const TableReader& table, const TimeColumns& columns) {
  if (!columns.nanoseconds) return table.time_stamp(columns.stamp);
  const auto seconds = table.number(columns.stamp);
  if (!seconds) return seconds.error();
  const auto nanoseconds = table.number(*columns.nanoseconds);
  if (!nanoseconds) return nanoseconds.error();
  constexpr double kMost_s = 4e9;  // differences in nanoseconds must fit
  constexpr double kMost_ns = 1e9;
  if (!(*seconds >= 0 && *seconds <= kMost_s && *nanoseconds >= 0 && *nanoseconds <= kMost_ns)) {
    return Error{ErrorCode::corrupt,
                 fmt::format("{}: {} s and {} ns are no time", table.head().source_name, *seconds, *nanoseconds)};
  }
  return table.head().epoch + std::chrono::seconds{std::llround(*seconds)} + Duration{std::llround(*nanoseconds)};
}

}  // namespace roseau::recorder
