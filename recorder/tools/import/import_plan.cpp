#include "recorder/tools/import/import_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <filesystem>

namespace roseau::recorder {

namespace {

std::optional<double> parse_rate(std::string_view text) {
  double rate_hz = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), rate_hz);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return rate_hz;
}

bool is_name_character(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-'; }

// "camera0", "/camera0" or "/camera0/image" -> "/camera0/image"; nothing for what can only be the beginning of a path.
std::optional<std::string> parse_image_topic(std::string_view text) {
  constexpr std::string_view kSuffix = "/image";
  if (text.starts_with('/')) text.remove_prefix(1);
  if (text.ends_with(kSuffix)) text.remove_suffix(kSuffix.size());
  if (text.empty() || !std::ranges::all_of(text, is_name_character)) return std::nullopt;
  return fmt::format("/{}{}", text, kSuffix);
}

template <class Value>
struct Named {
  Value value;
  std::string_view name;
};
template <class Value>
Named(Value, std::string_view) -> Named<Value>;

constexpr std::array kSonicFormats = {
    Named{SonicFormat::automatic, "auto"},     Named{SonicFormat::csv, "csv"}, Named{SonicFormat::toa5, "toa5"},
    Named{SonicFormat::tob1, "tob1"},          Named{SonicFormat::ghg, "ghg"}, Named{SonicFormat::nmea, "nmea"},
    Named{SonicFormat::trisonica, "trisonica"}};
constexpr std::array kTrackerFormats = {Named{TrackerFormat::automatic, "auto"}, Named{TrackerFormat::fastrak, "fastrak"},
                                        Named{TrackerFormat::fastrak_matrices, "fastrak_matrices"},
                                        Named{TrackerFormat::liberty, "liberty"}};
constexpr std::array kTrackerUnits = {Named{TrackerUnit::inch, "inch"}, Named{TrackerUnit::centimetre, "cm"},
                                      Named{TrackerUnit::metre, "m"}};
constexpr std::array kTemperatureUnits = {Named{TemperatureUnit::automatic, "auto"}, Named{TemperatureUnit::celsius, "celsius"},
                                          Named{TemperatureUnit::celsius, "C"}, Named{TemperatureUnit::kelvin, "kelvin"},
                                          Named{TemperatureUnit::kelvin, "K"}};
constexpr std::array kLengthUnits = {Named{LengthUnit::pixel, "px"}, Named{LengthUnit::metre, "m"},
                                     Named{LengthUnit::strain, "strain"}, Named{LengthUnit::other, "other"}};

template <class Table, class Value>
std::string_view name_in(const Table& table, Value value) {
  for (const auto& entry : table) {
    if (entry.value == value) return entry.name;
  }
  ROSEAU_CHECK(false);
  return {};
}

template <class Table>
auto value_in(const Table& table, std::string_view name, std::string_view what) -> Result<decltype(table[0].value)> {
  std::string known;
  for (const auto& entry : table) {
    if (entry.name == name) return entry.value;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", entry.name);
  }
  return Error{ErrorCode::invalid_argument, fmt::format("{} '{}' is not known: {}", what, name, known)};
}

}  // namespace

std::string_view to_string(SonicFormat format) { return name_in(kSonicFormats, format); }
Result<SonicFormat> sonic_format_from_string(std::string_view name) { return value_in(kSonicFormats, name, "format"); }
std::string_view to_string(TrackerFormat format) { return name_in(kTrackerFormats, format); }
Result<TrackerFormat> tracker_format_from_string(std::string_view name) { return value_in(kTrackerFormats, name, "format"); }
std::string_view to_string(TrackerUnit unit) { return name_in(kTrackerUnits, unit); }
Result<TrackerUnit> tracker_unit_from_string(std::string_view name) { return value_in(kTrackerUnits, name, "unit"); }
Result<TemperatureUnit> temperature_unit_from_string(std::string_view name) {
  return value_in(kTemperatureUnits, name, "temperature unit");
}
Result<LengthUnit> length_unit_from_string(std::string_view name) { return value_in(kLengthUnits, name, "unit"); }

NamedFile parse_named_file(std::string_view text) {
  const auto equals = text.find('=');
  const auto name = text.substr(0, equals);
  if (equals == std::string_view::npos || name.empty() || !std::ranges::all_of(name, is_name_character))
    return {std::nullopt, std::string(text)};
  return {std::string(name), std::string(text.substr(equals + 1))};
}

Result<ImportPlan::Video> parse_video_argument(std::string_view text, std::size_t index) {
  ImportPlan::Video video{.topic = fmt::format("/camera{}/image", index)};
  std::string_view path = text;
  // A '=' that no topic stands before belongs to the file's name: FILE alone was given.
  const auto equals = text.find('=');
  const auto topic = equals == std::string_view::npos ? std::nullopt : parse_image_topic(text.substr(0, equals));
  if (topic) {
    video.topic = *topic;
    path = text.substr(equals + 1);
  }
  // An '@' that no number follows belongs to the file's name too.
  if (const auto at = path.rfind('@'); at != std::string_view::npos) {
    if (const auto rate_hz = parse_rate(path.substr(at + 1))) {
      video.rate_hz = rate_hz;
      path = path.substr(0, at);
    }
  }
  if (path.empty()) {
    return Error{ErrorCode::invalid_argument, fmt::format("video '{}' should read TOPIC=FILE or TOPIC=FILE@FPS", text)};
  }
  if (video.rate_hz && !(*video.rate_hz > 0)) {
    return Error{ErrorCode::invalid_argument,
                 fmt::format("video '{}': {} frames per second make no sense", text, *video.rate_hz)};
  }
  video.path = path;
  return video;
}

std::string series_name(const std::string& path) {
  std::string name = std::filesystem::path(path).stem().string();
  std::ranges::replace_if(
      name, [](char c) { return !is_name_character(c); }, '_');
  return name.empty() ? "series" : name;
}

}  // namespace roseau::recorder
