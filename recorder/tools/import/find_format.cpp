#include "recorder/tools/import/find_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "drivers/wire/fastrak.h"
#include "drivers/wire/nmea0183.h"
#include "drivers/wire/trisonica.h"
#include "recorder/tools/import/byte_source.h"
#include "recorder/tools/import/log_reader.h"
#include "recorder/tools/import/text_table.h"

namespace roseau::recorder {

namespace {

constexpr std::size_t kLook = 16384;

Result<std::string> start_of(const std::string& path) {
  auto source = open_file(path);
  if (!source) return source.error();
  FileReader file(std::move(*source), path);
  const auto start = file.peek(kLook);
  if (!start) return start.error();
  return std::string(*start);
}

// The lines at the beginning that are whole.
std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  const bool is_all = text.size() < kLook;
  while (!text.empty()) {
    const auto end = text.find('\n');
    if (end == std::string_view::npos && !is_all && !lines.empty()) break;
    auto line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (!trimmed(line).empty()) lines.push_back(line);
  }
  return lines;
}

bool is_text(std::string_view bytes) {
  const auto odd = std::ranges::count_if(
      bytes, [](char c) { return (c >= 0 && c < ' ' && c != '\r' && c != '\n' && c != '\t') || c == 127; });
  return odd * 100 <= static_cast<std::ptrdiff_t>(bytes.size());
}

// What was seen, for a message: printable, short.
std::string seen(std::string_view start) {
  std::string text(start.substr(0, std::min<std::size_t>(start.find('\n'), 60)));
  for (auto& c : text) {
    if (c < ' ' || c > '~') c = '.';
  }
  return text;
}

Error unsure(const std::string& name, std::string_view start, std::string_view choices) {
  if (start.empty()) return {ErrorCode::corrupt, name + ": the file is empty"};
  return {ErrorCode::invalid_argument,
          fmt::format("{}: its format is not clear from its beginning, '{}': say which with {}", name, seen(start), choices)};
}

bool is_row_of_numbers(std::string_view line, std::size_t count) {
  std::vector<std::string_view> fields;
  split_fields(line, ' ', fields);
  return fields.size() == count &&
         std::ranges::all_of(fields, [](auto field) { return parse_cell(field, ' ').kind == Cell::Kind::number; });
}

// A number somewhere in one of the first lines: what a table has.
bool has_row_of_numbers(const std::vector<std::string_view>& lines) {
  return std::ranges::any_of(lines, [](auto line) {
    return line.find_first_of("0123456789") != std::string_view::npos && line.find('\0') == std::string_view::npos;
  });
}

}  // namespace

Result<SonicFormat> sonic_format_of(std::string_view start, const std::string& name) {
  constexpr std::string_view kChoices = "--format csv, toa5, tob1, ghg, nmea or trisonica";
  if (start.starts_with(kZipMark)) return SonicFormat::ghg;
  if (start.starts_with("\"TOB") || start.starts_with("TOB")) return SonicFormat::tob1;  // TOB2 and TOB3 are refused there
  if (start.starts_with("\"TOA5\"") || start.starts_with("TOA5,")) return SonicFormat::toa5;
  if (start.starts_with("Model:\t") || start.find("\nDATAH\t") != std::string_view::npos) return SonicFormat::ghg;
  if (looks_like_block_log(start)) return SonicFormat::trisonica;
  if (!is_text(start)) return unsure(name, start, kChoices);

  const auto lines = lines_of(start);
  std::size_t nmea = 0;
  std::size_t trisonica = 0;
  for (auto line : lines) {
    LogEntry entry;
    take_log_prefix(line, entry);
    const auto body = wire::nmea_body(line, false);
    if (body && !wire::nmea_kind(*body).empty()) ++nmea;
    if (wire::TriSonicaLayout::of_line(line)) ++trisonica;
  }
  if (nmea > 0 && trisonica > 0) return unsure(name, start, kChoices);
  if (nmea * 2 > lines.size()) return SonicFormat::nmea;
  if (trisonica * 2 > lines.size()) return SonicFormat::trisonica;
  if (nmea + trisonica > 0 || !has_row_of_numbers(lines)) return unsure(name, start, kChoices);
  return SonicFormat::csv;
}

Result<TrackerFormat> tracker_format_of(std::string_view start, const std::string& name) {
  constexpr std::string_view kChoices = "--format fastrak, fastrak_matrices or liberty";
  const auto lines = lines_of(start);
  if (!lines.empty()) {
    const auto head = in_lower_case(lines[0]);
    if (head.find("w1") != std::string::npos && head.find("loc1_x") != std::string::npos) return TrackerFormat::liberty;
  }
  if (lines.size() >= 4 && std::all_of(lines.begin(), lines.begin() + 4, [](auto line) { return is_row_of_numbers(line, 4); }))
    return TrackerFormat::fastrak_matrices;
  const auto text = wire::default_fastrak_layout();
  const auto binary = wire::quaternion_fastrak_layout();
  for (const auto& layout : {text, binary}) {
    for (std::size_t i = 0; i < std::min<std::size_t>(start.size(), 1024); ++i) {
      const auto rest = start.substr(i);
      if (!wire::is_fastrak_header(rest)) continue;
      if (wire::parse_fastrak_text(rest.substr(0, layout.text_bytes()), layout, wire::FastrakUnit::inch) ||
          wire::parse_fastrak_binary(rest.substr(0, layout.binary_bytes()), layout, wire::FastrakUnit::inch)) {
        return TrackerFormat::fastrak;
      }
    }
  }
  return unsure(name, start, kChoices);
}

Result<SonicFormat> find_sonic_format(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return SonicFormat::trisonica;
  const auto start = start_of(path);
  if (!start) return start.error();
  return sonic_format_of(*start, path);
}

Result<TrackerFormat> find_tracker_format(const std::string& path) {
  const auto start = start_of(path);
  if (!start) return start.error();
  return tracker_format_of(*start, path);
}

}  // namespace roseau::recorder
