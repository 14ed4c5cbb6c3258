#include "recorder/tools/import/sonic_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace roseau::recorder {

namespace {

constexpr double kKelvinAtZeroCelsius = 273.15;
constexpr double kFastestWind_mps = 100;

const ColumnRequest kU{"u", {"u", "ux", "u_mps", "u_sonic", "wind_u", "u_wind", "u_unrot", "wind_x"}};
const ColumnRequest kV{"v", {"v", "uy", "v_mps", "v_sonic", "wind_v", "v_wind", "v_unrot", "wind_y"}};
const ColumnRequest kW{"w", {"w", "uz", "w_mps", "w_sonic", "wind_w", "w_wind", "w_unrot", "wind_z"}};
const ColumnRequest kTemperature{
    "t", {"t_sonic", "ts", "tsonic", "sonic_temperature", "sonic_temp", "temp_sonic", "sonictemperature", "t_s"}};
const ColumnRequest kSpeedOfSound{"c", {"sos", "speed_of_sound", "speedofsound", "sonic_speed"}};
const ColumnRequest kStatus{"status", {}};  // diagnostics mean too many things to be guessed
const ColumnRequest kTime{"time", {"timestamp", "datetime", "date_time", "time"}};

const std::vector<std::string> kQuantities = {"u", "v", "w", "t", "c", "status", "time"};

using ColumnMap = std::map<std::string, std::string>;

struct Columns {
  std::size_t u = 0;
  std::size_t v = 0;
  std::optional<std::size_t> w;
  std::optional<std::size_t> temperature;
  std::optional<std::size_t> speed_of_sound;
  std::optional<std::size_t> status;
  std::optional<std::size_t> time;
};

Result<Columns> find_columns(const TableHead& head, const ColumnMap& map) {
  Columns columns;
  const auto u = require_column(head, kU, map);
  if (!u) return u.error();
  const auto v = require_column(head, kV, map);
  if (!v) return v.error();
  columns.u = *u;
  columns.v = *v;
  const std::vector<std::pair<const ColumnRequest*, std::optional<std::size_t>*>> optional_ones = {
      {&kW, &columns.w},
      {&kTemperature, &columns.temperature},
      {&kSpeedOfSound, &columns.speed_of_sound},
      {&kStatus, &columns.status},
      {&kTime, &columns.time}};
  for (const auto& [request, column] : optional_ones) {
    const auto found = find_column(head, *request, map);
    if (!found) return found.error();
    *column = *found;
  }
  return columns;
}

std::string describe(const TableHead& head, const Columns& columns) {
  std::string text = fmt::format("columns: u={}, v={}", head.columns[columns.u], head.columns[columns.v]);
  const auto add = [&](const char* name, const std::optional<std::size_t>& column) {
    if (column) text += fmt::format(", {}={}", name, head.columns[*column]);
  };
  add("w", columns.w);
  add("t", columns.temperature);
  add("c", columns.speed_of_sound);
  add("status", columns.status);
  add("time", columns.time);
  return text;
}

// Puts one row's numbers into a sample. Temperatures stay in the file's unit.
Result<WindSample> read_sample(const TableRows& rows, const Columns& columns) {
  WindSample sample;
  double status = 0;
  const std::vector<std::pair<std::optional<std::size_t>, double*>> targets = {
      {columns.u, &sample.u_mps},
      {columns.v, &sample.v_mps},
      {columns.w, &sample.w_mps},
      {columns.temperature, &sample.sonic_temperature_celsius},
      {columns.speed_of_sound, &sample.speed_of_sound_mps},
      {columns.status, &status}};
  for (const auto& [column, target] : targets) {
    if (!column) continue;
    const auto number = rows.number(*column);
    if (!number) return number.error();
    *target = *number;
  }
  const auto plausible = [](double wind_mps) { return std::abs(wind_mps) <= kFastestWind_mps; };
  const bool has_wind = plausible(sample.u_mps) && plausible(sample.v_mps) && (!columns.w || plausible(sample.w_mps));
  sample.valid = has_wind && status == 0;
  const bool is_code = status >= 0 && status <= 65535;  // NaN is none
  sample.device_status = is_code ? static_cast<std::uint16_t>(status) : std::uint16_t{65535};
  return sample;
}

Result<Duration> read_time(const TableHead& head, const TableRows& rows, std::size_t column) {
  const auto text = rows.fields()[column];
  if (const auto stamp = parse_time_stamp(text)) return *stamp;
  return Error{ErrorCode::corrupt,
               fmt::format("{}:{}: column '{}': '{}' is no time; known are seconds and 2019-07-30 12:00:00.05",
                           head.source_name, rows.line(), head.columns[column], text)};
}

bool says_kelvin(const TableHead& head, std::size_t column, const std::vector<WindSample>& samples) {
  if (!head.units.empty()) {
    const auto unit = normalised_name(head.units[column]);
    if (unit == "k" || unit == "kelvin") return true;
    if (unit.ends_with('c') || unit == "celsius") return false;  // C, degC, deg_C
  }
  const auto first =
      std::ranges::find_if(samples, [](const auto& sample) { return std::isfinite(sample.sonic_temperature_celsius); });
  constexpr double kWarmestCelsius = 150;
  return first != samples.end() && first->sonic_temperature_celsius > kWarmestCelsius;
}

void convert_temperatures(const TableHead& head, const Columns& columns, TemperatureUnit unit, SonicRecord& record) {
  if (!columns.temperature) return;
  const bool is_kelvin = unit == TemperatureUnit::automatic ? says_kelvin(head, *columns.temperature, record.samples)
                                                            : unit == TemperatureUnit::kelvin;
  record.remarks.push_back(fmt::format("sonic temperature taken as {}", is_kelvin ? "kelvin" : "degrees Celsius"));
  if (!is_kelvin) return;
  for (auto& sample : record.samples) sample.sonic_temperature_celsius -= kKelvinAtZeroCelsius;
}

}  // namespace

Result<TemperatureUnit> temperature_unit_from_string(std::string_view name) {
  if (name == "auto") return TemperatureUnit::automatic;
  if (name == "celsius" || name == "C") return TemperatureUnit::celsius;
  if (name == "kelvin" || name == "K") return TemperatureUnit::kelvin;
  return Error{ErrorCode::invalid_argument, fmt::format("temperature unit '{}' is not known: auto, celsius, kelvin", name)};
}

Result<SonicRecord> parse_sonic_file(std::string_view text, const std::string& source_name, const SonicFileOptions& options) {
  const auto map = parse_column_map(options.columns, kQuantities);
  if (!map) return map.error();
  const auto head = read_table_head(text, source_name, options.format);
  if (!head) return head.error();
  const auto columns = find_columns(*head, *map);
  if (!columns) return columns.error();

  SonicRecord record;
  record.remarks.push_back(describe(*head, *columns));
  std::vector<Duration> stamps;
  TableRows rows(*head);
  for (auto more = rows.next(); !more || *more; more = rows.next()) {
    if (!more) return more.error();
    const auto sample = read_sample(rows, *columns);
    if (!sample) return sample.error();
    record.samples.push_back(*sample);
    if (!sample->valid) ++record.invalid_samples;
    if (!columns->time) continue;
    const auto stamp = read_time(*head, rows, *columns->time);
    if (!stamp) return stamp.error();
    stamps.push_back(*stamp);
  }
  if (rows.was_cut()) record.remarks.push_back("the last line is cut short and was left out");
  if (record.samples.empty()) return Error{ErrorCode::corrupt, source_name + ": no rows"};
  convert_temperatures(*head, *columns, options.temperature_unit, record);

  auto times = place_records(record.samples.size(), stamps, options.rate_hz, source_name);
  if (!times) return times.error();
  record.times = std::move(*times);
  if (record.times.missing_rows > 0)
    record.remarks.push_back(fmt::format("by its times {} rows are missing", record.times.missing_rows));
  if (!stamps.empty()) record.begin = stamps.front();
  return record;
}

}  // namespace roseau::recorder
