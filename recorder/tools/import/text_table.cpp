#include "recorder/tools/import/text_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <limits>

namespace roseau::recorder {

namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr std::size_t kMostHeaderLines = 20;

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

// A line keeps its tabs: they may stand for empty fields.
std::string_view trimmed_line(std::string_view line) {
  const auto begin = line.find_first_not_of(" \r");
  if (begin == std::string_view::npos) return {};
  return line.substr(begin, line.find_last_not_of(" \r") - begin + 1);
}

std::string_view unquoted(std::string_view text) {
  text = trimmed(text);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
  return trimmed(text);
}

std::string in_lower_case(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

// Takes one line off `rest`, without its end.
std::string_view take_line(std::string_view& rest) {
  const auto end = rest.find('\n');
  auto line = rest.substr(0, end);
  rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

void split(std::string_view line, char separator, std::vector<std::string_view>& fields) {
  fields.clear();
  if (separator == ' ') {
    for (auto rest = trimmed(line); !rest.empty(); rest = trimmed(rest)) {
      const auto field = rest.substr(0, rest.find_first_of(kBlanks));
      fields.push_back(field);
      rest.remove_prefix(field.size());
    }
    return;
  }
  bool is_quoted = false;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') is_quoted = !is_quoted;
    if (line[i] != separator || is_quoted) continue;
    fields.push_back(unquoted(line.substr(begin, i - begin)));
    begin = i + 1;
  }
  fields.push_back(unquoted(line.substr(begin)));
}

char find_separator(std::string_view line) {
  // A semicolon or tab is never part of a number or name; a comma may be a decimal point then.
  for (const char separator : {';', '\t', ','}) {
    if (line.find(separator) != std::string_view::npos) return separator;
  }
  return ' ';
}

bool has_number(const std::vector<std::string_view>& fields, char separator) {
  return std::ranges::any_of(fields, [&](auto field) { return parse_cell(field, separator).kind == Cell::Kind::number; });
}

bool is_all_missing(const std::vector<std::string_view>& fields, char separator) {
  return std::ranges::all_of(fields, [&](auto field) { return parse_cell(field, separator).kind == Cell::Kind::missing; });
}

bool is_comment(std::string_view line) { return trimmed(line).empty() || line.starts_with('#'); }

std::vector<std::string> to_names(const std::vector<std::string_view>& fields) { return {fields.begin(), fields.end()}; }

std::vector<std::string> numbered_columns(std::size_t count) {
  std::vector<std::string> names;
  for (std::size_t i = 1; i <= count; ++i) names.push_back(std::to_string(i));
  return names;
}

bool is_toa5(std::string_view text) { return text.starts_with("\"TOA5\"") || text.starts_with("TOA5,"); }

// Line 1: station and program; 2: names; 3: units; 4: how each was processed; then the rows.
Result<TableHead> read_toa5_head(std::string_view text, TableHead head) {
  std::array<std::string_view, 4> lines;
  for (auto& line : lines) line = take_line(text);
  std::vector<std::string_view> fields;
  split(lines[1], ',', fields);
  head.columns = to_names(fields);
  split(lines[2], ',', fields);
  head.units = to_names(fields);
  if (trimmed(lines[3]).empty() || head.units.size() != head.columns.size()) {
    return Error{ErrorCode::truncated,
                 head.source_name + ": the four header lines of a TOA5 file are not complete: export it again from the logger"};
  }
  head.rows = text;
  head.first_line = lines.size() + 1;
  return head;
}

Result<TableHead> read_csv_head(std::string_view text, TableHead head) {
  std::vector<std::string_view> fields;
  for (std::size_t line_number = 1; !text.empty() && line_number <= kMostHeaderLines; ++line_number) {
    head.rows = text;
    head.first_line = line_number;
    const auto line = trimmed_line(take_line(text));
    if (is_comment(line)) continue;
    head.separator = head.columns.empty() ? find_separator(line) : head.separator;
    split(line, head.separator, fields);
    if (has_number(fields, head.separator) || (!head.columns.empty() && is_all_missing(fields, head.separator))) {
      if (head.columns.empty()) head.columns = numbered_columns(fields.size());
      return head;
    }
    if (head.columns.empty()) {
      head.columns = to_names(fields);
    } else if (head.units.empty() && fields.size() == head.columns.size()) {
      head.units = to_names(fields);
    }
  }
  return Error{ErrorCode::corrupt, fmt::format("{}: no row of numbers in its first {} lines: is this the right file?",
                                               head.source_name, kMostHeaderLines)};
}

}  // namespace

Result<TableFormat> table_format_from_string(std::string_view name) {
  if (name == "auto") return TableFormat::automatic;
  if (name == "csv") return TableFormat::csv;
  if (name == "toa5") return TableFormat::toa5;
  return Error{ErrorCode::invalid_argument, fmt::format("format '{}' is not known: auto, csv, toa5", name)};
}

std::string TableHead::column_list() const { return fmt::format("{}", fmt::join(columns, ", ")); }

Result<TableHead> read_table_head(std::string_view text, std::string source_name, TableFormat format) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  TableHead head{.source_name = std::move(source_name)};
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos)
    return Error{ErrorCode::corrupt, head.source_name + ": the file is empty"};
  const bool says_toa5 = is_toa5(text);
  if (format == TableFormat::toa5 && !says_toa5) {
    return Error{ErrorCode::corrupt, head.source_name + ":1: no TOA5 file, which would begin with \"TOA5\": try format csv"};
  }
  if (says_toa5 && format != TableFormat::csv) return read_toa5_head(text, std::move(head));
  return read_csv_head(text, std::move(head));
}

Cell parse_cell(std::string_view text, char separator) {
  text = unquoted(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  std::string with_point;
  if (separator == ';' && text.find(',') != std::string_view::npos) {
    with_point = text;
    std::ranges::replace(with_point, ',', '.');
    text = with_point;
  }
  const bool could_be_number = !text.empty() && text.find_first_not_of("+-.0123456789eE") == std::string_view::npos;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (could_be_number && error == std::errc{} && end == text.data() + text.size()) {
    const bool says_missing = value == -9999 || value == -7999 || value == 7999;
    return {says_missing ? Cell::Kind::missing : Cell::Kind::number, value};
  }
  constexpr std::array<std::string_view, 7> kMissing = {"", "nan", "na", "null", "inf", "-inf", "-nan"};
  const auto lower = in_lower_case(text);
  return {std::ranges::find(kMissing, lower) != kMissing.end() ? Cell::Kind::missing : Cell::Kind::text, 0};
}

Result<bool> TableRows::next() {
  while (!rest_.empty()) {
    const bool has_end = rest_.find('\n') != std::string_view::npos;
    const auto line = trimmed_line(take_line(rest_));
    ++line_;
    if (is_comment(line)) continue;
    split(line, head_.separator, fields_);
    if (fields_.size() == head_.columns.size()) return true;
    // Some programs end each row with a separator.
    if (fields_.size() == head_.columns.size() + 1 && fields_.back().empty()) {
      fields_.pop_back();
      return true;
    }
    if (!has_end && fields_.size() < head_.columns.size()) {
      was_cut_ = true;
      return false;
    }
    return Error{ErrorCode::corrupt, fmt::format("{}:{}: {} fields where there are {} columns ({})", head_.source_name,
                                                 this->line(), fields_.size(), head_.columns.size(), head_.column_list())};
  }
  return false;
}

Result<double> TableRows::number(std::size_t column) const {
  const Cell cell = parse_cell(fields_[column], head_.separator);
  if (cell.kind == Cell::Kind::number) return cell.number;
  if (cell.kind == Cell::Kind::missing) return std::numeric_limits<double>::quiet_NaN();
  return Error{ErrorCode::corrupt, fmt::format("{}:{}: column '{}': '{}' is no number", head_.source_name, line(),
                                               head_.columns[column], fields_[column])};
}

Result<std::map<std::string, std::string>> parse_column_map(std::string_view text, const std::vector<std::string>& known) {
  std::map<std::string, std::string> map;
  std::vector<std::string_view> pairs;
  if (!text.empty()) split(text, ',', pairs);
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

}  // namespace roseau::recorder
