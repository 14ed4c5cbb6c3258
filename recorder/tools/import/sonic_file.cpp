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
const std::vector<std::string> kQuantities = {"u", "v", "w", "t", "c", "status", "time"};

using ColumnMap = std::map<std::string, std::string>;

struct Columns {
  std::size_t u = 0;
  std::size_t v = 0;
  std::optional<std::size_t> w;
  std::optional<std::size_t> temperature;
  std::optional<std::size_t> speed_of_sound;
  std::optional<std::size_t> status;
  std::optional<TimeColumns> time;
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
      {&kStatus, &columns.status}};
  for (const auto& [request, column] : optional_ones) {
    const auto found = find_column(head, *request, map);
    if (!found) return found.error();
    *column = *found;
  }
  const auto time = find_time_columns(head, map);
  if (!time) return time.error();
  columns.time = *time;
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
  return text;
}

// Puts one row's numbers into a sample. Temperatures stay in the file's unit.
Result<WindSample> read_sample(const TableReader& rows, const Columns& columns) {
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

// By the file's unit; nothing where it does not say.
std::optional<bool> says_kelvin(const TableHead& head, std::size_t column) {
  if (head.units.size() <= column) return std::nullopt;
  const auto unit = normalised_name(head.units[column]);
  if (unit == "k" || unit == "kelvin") return true;
  if (unit.ends_with('c') || unit == "celsius") return false;  // C, degC, deg_C
  return std::nullopt;
}

class WindRows : public RowMeaning {
 public:
  WindRows(const TableHead& head, Columns columns, TemperatureUnit unit, StreamInfo info)
      : columns_(std::move(columns)), info_(std::move(info)), description_(describe(head, columns_)) {
    if (unit != TemperatureUnit::automatic) {
      is_kelvin_ = unit == TemperatureUnit::kelvin;
    } else if (columns_.temperature) {
      is_kelvin_ = says_kelvin(head, *columns_.temperature);
    }
  }

  Result<void> read(const TableReader& row, std::vector<Item>& items) override {
    auto sample = read_sample(row, columns_);
    if (!sample) return sample.error();
    auto& temperature = sample->sonic_temperature_celsius;
    constexpr double kWarmestCelsius = 150;
    if (!is_kelvin_ && std::isfinite(temperature)) is_kelvin_ = temperature > kWarmestCelsius;
    if (is_kelvin_.value_or(false)) temperature -= kKelvinAtZeroCelsius;
    items.push_back({.payload = *sample, .status = static_cast<std::uint16_t>(sample->valid ? kStatusOk : kStatusIncomplete)});
    return {};
  }
  std::vector<StreamInfo> streams() const override { return {info_}; }
  std::vector<std::string> remarks() const override {
    std::vector<std::string> remarks{description_};
    if (columns_.temperature)
      remarks.push_back(
          fmt::format("sonic temperature taken as {}", is_kelvin_.value_or(false) ? "kelvin" : "degrees Celsius"));
    return remarks;
  }

 private:
  Columns columns_;
  StreamInfo info_;
  std::string description_;
  std::optional<bool> is_kelvin_;  // by the file's units, else by the first value
};

}  // namespace

Result<std::unique_ptr<RowMeaning>> make_wind_rows(const TableReader& table, const SonicFileOptions& options, StreamInfo info,
                                                   std::optional<TimeColumns>& time) {
  const auto map = parse_column_map(options.columns, kQuantities);
  if (!map) return map.error();
  auto columns = find_columns(table.head(), *map);
  if (!columns) return columns.error();
  time = columns->time;
  return std::unique_ptr<RowMeaning>(
      std::make_unique<WindRows>(table.head(), std::move(*columns), options.temperature_unit, std::move(info)));
}

}  // namespace roseau::recorder
