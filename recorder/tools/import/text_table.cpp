#include "recorder/tools/import/text_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <iterator>
#include <limits>

#include "recorder/tools/import/record_times.h"

namespace roseau::recorder {

namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr std::size_t kMostHeaderLines = 20;
constexpr std::size_t kMostGhgHeaderLines = 100;
constexpr std::string_view kUnitsMark = "DATAU";

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
bool is_ghg(std::string_view text) { return text.starts_with("Model:\t") || text.find("\nDATAH\t") != std::string_view::npos; }

// "Ts (K)" -> "K"
std::string unit_in_name(std::string_view name) {
  const auto begin = name.find_first_of("([");
  if (begin == std::string_view::npos) return {};
  return std::string(name.substr(begin + 1, name.find_first_of(")]", begin) - begin - 1));
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

std::string in_lower_case(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

void split_fields(std::string_view line, char separator, std::vector<std::string_view>& fields) {
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

Result<std::unique_ptr<TextTable>> TextTable::open(FileReader file, TableFormat format) {
  std::unique_ptr<TextTable> table(new TextTable(std::move(file)));
  if (auto read = table->read_head(format); !read) return read.error();
  if (auto rewound = table->rewind(); !rewound) return rewound.error();
  return table;
}

Result<void> TextTable::read_head(TableFormat format) {
  constexpr std::size_t kLook = 4096;
  if (auto skipped = skip_byte_order_mark(); !skipped) return skipped;
  const auto start = file_.peek(kLook);
  if (!start) return start.error();
  if (start->find_first_not_of(" \t\r\n") == std::string_view::npos && start->size() < kLook)
    return Error{ErrorCode::corrupt, head_.source_name + ": the file is empty"};
  const bool says_toa5 = is_toa5(*start);
  if (format == TableFormat::toa5 && !says_toa5) {
    return Error{ErrorCode::corrupt, head_.source_name + ":1: no TOA5 file, which would begin with \"TOA5\": try format csv"};
  }
  if (says_toa5 && format != TableFormat::csv) return read_toa5_head();
  if (format == TableFormat::ghg || (format == TableFormat::automatic && is_ghg(*start))) return read_ghg_head();
  return read_csv_head();
}

Result<void> TextTable::skip_byte_order_mark() {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  const auto start = file_.peek(kByteOrderMark.size());
  if (!start) return start.error();
  if (*start != kByteOrderMark) return {};
  if (auto taken = file_.take(kByteOrderMark.size()); !taken) return taken.error();
  return {};
}

// Line 1: station and program; 2: names; 3: units; 4: how each was processed; then the rows.
Result<void> TextTable::read_toa5_head() {
  std::array<std::string, 4> lines;
  for (auto& text : lines) {
    const auto line = file_.line();
    if (!line) return line.error();
    text = line->value_or("");
  }
  std::vector<std::string_view> fields;
  split_fields(lines[1], ',', fields);
  head_.columns = to_names(fields);
  split_fields(lines[2], ',', fields);
  head_.units = to_names(fields);
  if (trimmed(lines[3]).empty() || head_.units.size() != head_.columns.size()) {
    return Error{
        ErrorCode::truncated,
        head_.source_name + ": the four header lines of a TOA5 file are not complete: export it again from the logger"};
  }
  split_fields(lines[0], ',', fields);
  if (fields.size() == 8) head_.description = fmt::format("logger {} '{}', table {}", fields[2], fields[1], fields[7]);
  head_lines_ = lines.size();
  return {};
}

Result<void> TextTable::read_ghg_head() {
  separator_ = '\t';
  std::vector<std::string_view> fields;
  for (std::size_t i = 0; i < kMostGhgHeaderLines; ++i) {
    const auto line = file_.line();
    if (!line) return line.error();
    if (!*line) break;
    const auto text = trimmed_line(**line);
    if (text.starts_with("Model:") || text.starts_with("Timezone:"))
      head_.description += fmt::format("{}{}", head_.description.empty() ? "" : ", ", trimmed(text));
    if (!text.starts_with("DATAH\t")) continue;
    split_fields(text, separator_, fields);
    head_.columns = to_names(fields);
    std::ranges::replace(head_.description, '\t', ' ');
    std::ranges::transform(head_.columns, std::back_inserter(head_.units), unit_in_name);
    const auto next = file_.peek(kUnitsMark.size());
    if (!next) return next.error();
    if (*next == kUnitsMark) {
      const auto units = file_.line();
      if (!units) return units.error();
      split_fields(trimmed_line(units->value_or("")), separator_, fields);
      if (fields.size() == head_.columns.size()) head_.units = to_names(fields);
    }
    head_lines_ = file_.line_number();
    return {};
  }
  return Error{ErrorCode::corrupt, fmt::format("{}: no line DATAH among its first {}: this is no data of a GHG archive",
                                               head_.source_name, kMostGhgHeaderLines)};
}

Result<void> TextTable::read_csv_head() {
  std::vector<std::string_view> fields;
  for (std::size_t line_number = 1; line_number <= kMostHeaderLines; ++line_number) {
    const auto read = file_.line();
    if (!read) return read.error();
    if (!*read) break;
    const auto line = trimmed_line(**read);
    if (is_comment(line)) continue;
    separator_ = head_.columns.empty() ? find_separator(line) : separator_;
    split_fields(line, separator_, fields);
    if (has_number(fields, separator_) || (!head_.columns.empty() && is_all_missing(fields, separator_))) {
      if (head_.columns.empty()) head_.columns = numbered_columns(fields.size());
      head_lines_ = file_.line_number() - 1;
      return {};
    }
    if (head_.columns.empty()) {
      head_.columns = to_names(fields);
    } else if (head_.units.empty() && fields.size() == head_.columns.size()) {
      head_.units = to_names(fields);
    }
  }
  return Error{ErrorCode::corrupt, fmt::format("{}: no row of numbers in its first {} lines: is this the right file?",
                                               head_.source_name, kMostHeaderLines)};
}

Result<void> TextTable::rewind() {
  was_cut_ = false;
  if (auto rewound = file_.rewind(); !rewound) return rewound;
  if (auto skipped = skip_byte_order_mark(); !skipped) return skipped;
  for (std::size_t i = 0; i < head_lines_; ++i) {
    const auto line = file_.line();
    if (!line) return line.error();
  }
  return {};
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

Result<bool> TextTable::next() {
  while (true) {
    const auto read = file_.line();
    if (!read) return read.error();
    if (!*read) return false;
    const auto line = trimmed_line(**read);
    if (is_comment(line)) continue;
    split_fields(line, separator_, fields_);
    if (fields_.size() == head_.columns.size()) return true;
    // Some programs end each row with a separator.
    if (fields_.size() == head_.columns.size() + 1 && fields_.back().empty()) {
      fields_.pop_back();
      return true;
    }
    if (!file_.line_had_end() && fields_.size() < head_.columns.size()) {
      was_cut_ = true;
      return false;
    }
    return Error{ErrorCode::corrupt,
                 fmt::format("{}:{}: {} fields where there are {} columns ({})", head_.source_name, file_.line_number(),
                             fields_.size(), head_.columns.size(), head_.column_list())};
  }
}

std::string TextTable::where(std::size_t column) const {
  return fmt::format("{}:{}: column '{}': '{}'", head_.source_name, file_.line_number(), head_.columns[column],
                     fields_[column]);
}

Result<double> TextTable::number(std::size_t column) const {
  const Cell cell = parse_cell(fields_[column], separator_);
  if (cell.kind == Cell::Kind::number) return cell.number;
  if (cell.kind == Cell::Kind::missing) return std::numeric_limits<double>::quiet_NaN();
  return Error{ErrorCode::corrupt, where(column) + " is no number"};
}

Result<Duration> TextTable::time_stamp(std::size_t column) const {
  if (const auto stamp = parse_time_stamp(fields_[column])) return *stamp;
  return Error{ErrorCode::corrupt, where(column) + " is no time; known are seconds and 2019-07-30 12:00:00.05"};
}

}  // namespace roseau::recorder
