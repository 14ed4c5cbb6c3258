// CF-1.8: every stream on a time axis of its own, all of one station: the place where the session was recorded.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "core/toml/table.h"
#include "core/wind_geometry.h"
#include "recorder/tools/export/export_session.h"
#include "recorder/tools/export/netcdf_file.h"
#include "recorder/tools/export/sample_table.h"
#include "recorder/tools/export/session_part.h"
#include "recorder/tools/selection/civil_time.h"

namespace roseau::recorder {

namespace {

constexpr std::size_t kRowsHeld = 16384;

const std::set<SampleKind>& kinds_held() {
  static const std::set<SampleKind> kinds = {
      SampleKind::wind,           SampleKind::displacement,  SampleKind::station_pose,     SampleKind::marker_positions,
      SampleKind::identification, SampleKind::wind_estimate, SampleKind::wind_calibration, SampleKind::clock_state,
      SampleKind::modal_state};
  return kinds;
}

/// What stands beside u, v, w where the instrument's bearing is known: wind in the earth's axes.
struct EarthWind {
  static const std::vector<Column>& columns() {
    static const std::vector<Column> columns = {{"eastward_wind", "m s-1", "wind towards the east"},
                                                {"northward_wind", "m s-1", "wind towards the north"},
                                                {"wind_speed", "m s-1", "horizontal wind speed"},
                                                {"wind_from_direction", "degree", "where the wind comes from, from north"}};
    return columns;
  }
  double north_offset_deg = 0;
  WindAxes axes = WindAxes::gill_spar;

  std::vector<double> of(const WindSample& wind) const {
    const double speed = std::hypot(wind.u_mps, wind.v_mps);
    const double from_deg = wind_direction_deg(wind.u_mps, wind.v_mps, north_offset_deg, axes);
    const double from_rad = from_deg * std::numbers::pi / 180;
    return {-speed * std::sin(from_rad), -speed * std::cos(from_rad), speed, from_deg};
  }
};

double number_of(const Field& field) {
  if (const auto* number = std::get_if<double>(&field)) return *number;
  return static_cast<double>(std::get<std::int64_t>(field));
}

std::string unit_of(const Column& column, LengthUnit length) {
  if (column.name != "x" && column.name != "y") return column.unit;
  return length == LengthUnit::metre ? "m" : "1";
}

/// Variables of one stream. Definition waits for the first sample, which tells units and how many things it holds.
class StreamVariables {
 public:
  StreamVariables(const SessionPart::Stream& stream, std::string prefix, Duration base)
      : stream_(stream), prefix_(std::move(prefix)), base_(base) {
    const auto& metadata = stream.info.metadata;
    const auto north = metadata.find("north_offset_deg");
    if (stream.kind != SampleKind::wind || north == metadata.end()) return;
    earth_.emplace();
    earth_->north_offset_deg = std::strtod(north->second.c_str(), nullptr);
    if (const auto axes = metadata.find("axes"); axes != metadata.end()) {
      if (const auto known = wind_axes_from_string(axes->second); known) earth_->axes = *known;
    }
  }

  /// The shape of the variables, by the first sample.
  void see_first(const Sample& sample) {
    if (is_seen_) return;
    is_seen_ = true;
    first_ = sample;
    const auto rows = rows_of(sample);
    per_row_ = std::max<std::size_t>(rows.size(), 1);
    has_items_ = sample.kind() == SampleKind::marker_positions || sample.kind() == SampleKind::modal_state;
    for (const auto& row : rows) {
      if (sample.kind() == SampleKind::marker_positions) items_.push_back(std::get<std::string>(row.front()));
      if (sample.kind() == SampleKind::modal_state) items_.push_back(fmt::format("{}", std::get<std::int64_t>(row.at(1))));
    }
  }
  bool is_seen() const { return is_seen_; }

  void define(NetcdfFile& file, const std::string& time_units, const std::string& coordinates) {
    const std::string time_name = prefix_ + "time";
    std::vector<int> dimensions = {file.dimension(time_name, NetcdfFile::kUnlimited)};
    time_ = file.variable(time_name, dimensions, true);
    file.attribute(time_, "units", time_units);
    file.attribute(time_, "long_name", "sample time");
    if (time_units != "s") {
      file.attribute(time_, "standard_name", "time");
      file.attribute(time_, "calendar", "standard");
    }
    file.attribute(time_, "axis", "T");
    std::string its_coordinates = coordinates;
    if (has_items_) {
      const std::string item = prefix_ + (stream_.kind == SampleKind::modal_state ? "mode" : "marker");
      dimensions.push_back(file.dimension(item, per_row_));
      const int names = file.text_variable(item + "_name", items_, dimensions.back());
      file.attribute(names, "long_name", "which one");
      its_coordinates += " " + item + "_name";
    }
    const auto& columns = columns_of(stream_.kind);
    const auto rows = rows_of(first_);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const bool is_text = rows.empty() || std::holds_alternative<std::string>(rows.front().at(i));
      if (!is_text) define_one(file, columns[i], dimensions, its_coordinates, i);
    }
    if (!earth_) return;
    for (const Column& column : EarthWind::columns()) {
      const int id = file.variable(prefix_ + column.name, dimensions);
      describe(file, id, column, column.unit, its_coordinates);
      file.attribute(id, "standard_name", column.name);
      file.attribute(id, "comment", "from u, v and the north offset; the instrument is taken as upright");
      earth_variables_.push_back({id, {}});
    }
  }

  Result<void> add(NetcdfFile& file, const Sample& sample) {
    time_values_.push_back(to_seconds(sample.header.sample_time.time_since_epoch() - base_));
    const auto rows = rows_of(sample);
    for (auto& variable : variables_) {
      for (std::size_t item = 0; item < per_row_; ++item) variable.values.push_back(value(rows, item, variable.column));
    }
    if (earth_) {
      const auto values = earth_->of(std::get<WindSample>(sample.payload));
      for (std::size_t i = 0; i < values.size(); ++i) earth_variables_[i].values.push_back(values[i]);
    }
    return time_values_.size() >= kRowsHeld ? flush(file) : Result<void>{};
  }

  Result<void> flush(NetcdfFile& file) {
    const std::size_t rows = time_values_.size();
    file.put(time_, written_, rows, 1, time_values_);
    for (auto& variable : variables_) {
      file.put(variable.id, written_, rows, per_row_, variable.values);
      variable.values.clear();
    }
    for (auto& variable : earth_variables_) {
      file.put(variable.id, written_, rows, 1, variable.values);
      variable.values.clear();
    }
    written_ += rows;
    time_values_.clear();
    return file.status();
  }

  ExportReport::Stream report(const std::filesystem::path& path) const {
    return {.topic = stream_.info.topic, .path = path, .rows = written_};
  }

 private:
  struct Variable {
    int id = -1;
    std::vector<double> values;
    std::size_t column = 0;
  };

  static void describe(NetcdfFile& file, int id, const Column& column, const std::string& unit,
                       const std::string& coordinates) {
    file.attribute(id, "units", unit);
    file.attribute(id, "long_name", column.description);
    file.attribute(id, "coordinates", coordinates);
  }

  void define_one(NetcdfFile& file, const Column& column, const std::vector<int>& dimensions, const std::string& coordinates,
                  std::size_t index) {
    const auto* displacement = std::get_if<Displacement>(&first_.payload);
    const LengthUnit length = displacement != nullptr ? displacement->unit : LengthUnit::other;
    const int id = file.variable(prefix_ + column.name, dimensions);
    describe(file, id, column, unit_of(column, length), coordinates);
    const auto& metadata = stream_.info.metadata;
    if (stream_.kind == SampleKind::wind && index < 3) {
      // The instrument's own axes: no standard name has them.
      const auto axes = metadata.find("axes");
      file.attribute(id, "axes", axes == metadata.end() ? "not said" : axes->second);
      if (earth_) file.attribute(id, "north_offset_deg", earth_->north_offset_deg);
    }
    if (column.name == "speed_of_sound_mps") file.attribute(id, "standard_name", "speed_of_sound_in_air");
    if (displacement != nullptr && index < 2) {
      file.attribute(id, "comment", "in " + std::string(to_string(displacement->unit)));
    }
    if (const auto source = metadata.find("source"); source != metadata.end())
      file.attribute(id, "source_topic", source->second);
    variables_.push_back({id, {}, index});
  }

  /// Markers are found by name: a sample may hold them in another order, or not all.
  double value(const std::vector<std::vector<Field>>& rows, std::size_t item, std::size_t column) const {
    if (stream_.kind != SampleKind::marker_positions)
      return item < rows.size() ? number_of(rows[item].at(column)) : kNotMeasured;
    if (item < rows.size() && std::get<std::string>(rows[item].front()) == items_[item])
      return number_of(rows[item].at(column));
    const auto found =
        std::ranges::find_if(rows, [&](const auto& row) { return std::get<std::string>(row.front()) == items_.at(item); });
    return found == rows.end() ? kNotMeasured : number_of(found->at(column));
  }

  const SessionPart::Stream& stream_;
  std::string prefix_;
  Duration base_;
  std::optional<EarthWind> earth_;
  bool is_seen_ = false;
  bool has_items_ = false;
  Sample first_;
  std::size_t per_row_ = 1;
  std::vector<std::string> items_;
  int time_ = -1;
  std::vector<double> time_values_;
  std::vector<Variable> variables_;
  std::vector<Variable> earth_variables_;
  std::size_t written_ = 0;
};

/// Where it was, as the site sheet says.
struct Position {
  std::optional<double> latitude_deg;
  std::optional<double> longitude_deg;
  std::optional<double> altitude_m;
};

Position position_of(SessionPart& part) {
  Position position;
  std::vector<std::byte> buffer;
  for (const auto& entry : part.reader().index().attachments) {
    if (entry.name != mcap::kSiteAttachment) continue;
    const auto attachment = part.reader().read(entry, buffer);
    if (!attachment) continue;
    const std::string text(reinterpret_cast<const char*>(attachment->data.data()), attachment->data.size());
    auto sheet = TomlTable::parse(text, "site.toml");
    if (!sheet) continue;
    auto place = sheet->table("position");
    position.latitude_deg = place.optional_number("latitude_deg");
    position.longitude_deg = place.optional_number("longitude_deg");
    position.altitude_m = place.optional_number("altitude_m");
  }
  return position;
}

/// The scalar variables that say where and what; their names, for the attribute "coordinates".
std::string define_station(NetcdfFile& file, SessionPart& part) {
  const auto& other = part.info().other;
  const auto name = other.find("name");
  const int station = file.text_variable("station", {name == other.end() ? part.path().stem().string() : name->second});
  file.attribute(station, "cf_role", std::string("timeseries_id"));
  file.attribute(station, "long_name", std::string("session"));
  std::string coordinates = "station";
  const Position position = position_of(part);
  const auto scalar = [&](const char* variable, const std::optional<double>& value, const char* unit) {
    if (!value) return;
    const int id = file.variable(variable, {});
    file.attribute(id, "standard_name", std::string(variable));
    file.attribute(id, "units", std::string(unit));
    coordinates += std::string(" ") + variable;
  };
  scalar("latitude", position.latitude_deg, "degrees_north");
  scalar("longitude", position.longitude_deg, "degrees_east");
  scalar("altitude", position.altitude_m, "m");
  return coordinates;
}

std::string identifier_of(const std::string& topic) {
  std::string name = file_name_of(topic);
  std::ranges::replace_if(
      name, [](unsigned char c) { return c == '-' || c == '.' || c >= 0x80; }, '_');
  return std::isalpha(static_cast<unsigned char>(name.front())) != 0 ? name : "stream_" + name;
}

class NetcdfExport {
 public:
  explicit NetcdfExport(SessionPart& part) : part_(part) {
    const auto utc = part.utc_minus_host_time();
    const HostTime begin = part.begin();
    if (utc) {
      // From the whole second before the session's start.
      const Duration civil = begin.time_since_epoch() + *utc;
      const auto second = std::chrono::floor<std::chrono::seconds>(civil);
      base_ = second - *utc;
      time_units_ = "seconds since " + utc_text(Duration(second).count(), 0, ' ', " UTC");
    } else {
      base_ = begin.time_since_epoch();
      time_units_ = "s";
    }
  }

  Result<void> run(const std::filesystem::path& path, const ToolProgress& progress) {
    const bool is_single = part_.streams().size() == 1;
    for (const auto& [id, stream] : part_.streams()) {
      streams_.try_emplace(id, stream, is_single ? "" : identifier_of(stream.info.topic) + "_", base_);
    }
    if (auto seen = see_first_samples(); !seen) return seen;
    auto file = NetcdfFile::create(path);
    if (!file) return file.error();
    define(**file);
    auto done = part_.for_each_sample(
        [&](std::uint16_t id, const Sample& sample) {
          const auto stream = streams_.find(id);
          return stream == streams_.end() ? Result<void>{} : stream->second.add(**file, sample);
        },
        progress);
    for (auto& [id, stream] : streams_) {
      if (done) done = stream.flush(**file);
    }
    put_position(**file);
    if (done) done = (*file)->close();
    for (auto& [id, stream] : streams_) part_.report().streams.push_back(stream.report(path));
    return done;
  }

 private:
  /// Streams that have none in this part get no variables.
  Result<void> see_first_samples() {
    const auto damage = part_.report().damage;
    std::size_t seen = 0;
    auto done = part_.for_each_sample(
        [&](std::uint16_t id, const Sample& sample) -> Result<void> {
          auto& stream = streams_.at(id);
          if (!stream.is_seen()) ++seen;
          stream.see_first(sample);
          return {};
        },
        [&](double) { return seen < streams_.size(); });
    part_.report().damage = damage;  // said again when they are written
    part_.report().stopped = false;
    std::erase_if(streams_, [](const auto& entry) { return !entry.second.is_seen(); });
    if (done && streams_.empty()) {
      return Error{ErrorCode::invalid_argument, "there is no sample in the part that was asked for"};
    }
    return done;
  }

  void define(NetcdfFile& file) {
    const auto text = [&file](const char* name, const std::string& value) { file.attribute(NetcdfFile::kGlobal, name, value); };
    text("Conventions", "CF-1.8");
    text("featureType", "timeSeries");
    const auto& other = part_.info().other;
    const auto name = other.find("name");
    text("title", "roseau session " + (name == other.end() ? part_.path().stem().string() : name->second));
    text("source", part_.path().filename().string());
    text("history", fmt::format("recorded by roseau {} and exported by roseau export from {}", part_.info().program_version,
                                part_.path().filename().string()));
    if (!part_.info().session_id.empty()) text("session_id", part_.info().session_id);
    const std::string coordinates = define_station(file, part_);
    for (auto& [id, stream] : streams_) stream.define(file, time_units_, coordinates);
  }

  void put_position(NetcdfFile& file) {
    const Position position = position_of(part_);
    file.put_scalar("latitude", position.latitude_deg);
    file.put_scalar("longitude", position.longitude_deg);
    file.put_scalar("altitude", position.altitude_m);
  }

  SessionPart& part_;
  Duration base_{0};
  std::string time_units_;
  std::map<std::uint16_t, StreamVariables> streams_;
};

}  // namespace

Result<ExportReport> export_netcdf(const std::filesystem::path& session, const SelectionOptions& options,
                                   const std::filesystem::path& file, const ToolProgress& progress) {
  auto part = SessionPart::open(session, options);
  if (!part) return part.error();
  for (const auto& [id, stream] : part->streams()) {
    if (kinds_held().contains(stream.kind) || stream.messages == 0) continue;
    part->report().left_out.push_back(stream.info.topic + ": " + stream.info.kind + " has no place in a NetCDF file");
  }
  part->keep([](const SessionPart::Stream& stream) { return kinds_held().contains(stream.kind) && stream.messages > 0; });
  if (part->streams().empty()) {
    return Error{ErrorCode::invalid_argument,
                 session.string() + " holds no wind, displacement, pose or estimate under the topics that were asked for"};
  }
  if (auto absent = require_absent(file); !absent) return absent.error();
  if (auto done = NetcdfExport(*part).run(file, progress); !done) return done.error();
  return std::move(part->report());
}

}  // namespace roseau::recorder
