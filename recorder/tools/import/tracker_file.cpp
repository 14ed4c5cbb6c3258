#include "recorder/tools/import/tracker_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "drivers/wire/rotations.h"
#include "recorder/tools/import/text_table.h"

namespace roseau::recorder {

namespace {

constexpr std::size_t kRows = 4;
constexpr std::size_t kMostStations = 16;

StreamInfo pose_stream(const std::string& device, std::size_t station, TrackerUnit unit) {
  return {.topic = fmt::format("/{}/station{}/pose", device, station),
          .kind = std::string(to_string(SampleKind::station_pose)),
          .role = StreamRole::raw,
          .device = device,
          .metadata = {{"station", fmt::format("{}", station)}, {"unit", std::string(to_string(unit))}, {"delay_s", "0"}}};
}

class MatrixTable : public TableReader {
 public:
  explicit MatrixTable(FileReader file) : file_(std::move(file)) {
    head_.source_name = file_.name();
    for (std::size_t i = 0; i < numbers_.size(); ++i) head_.columns.push_back(fmt::format("m{}{}", i / kRows, i % kRows));
  }

  Result<void> rewind() override {
    was_cut_ = false;
    return file_.rewind();
  }
  Result<bool> next() override {
    std::size_t row = 0;
    while (row < kRows) {
      const auto line = file_.line();
      if (!line) return line.error();
      if (!*line) {
        was_cut_ = row > 0;
        return false;
      }
      if (trimmed(**line).empty() && row == 0) continue;
      split_fields(**line, ' ', fields_);
      const bool may_be_cut = !file_.line_had_end() && fields_.size() < kRows;
      if (may_be_cut) {
        was_cut_ = true;
        return false;
      }
      if (auto read = read_row(row); !read) return read.error();
      ++row;
    }
    return true;
  }
  Result<double> number(std::size_t column) const override { return numbers_.at(column); }
  Result<Duration> time_stamp(std::size_t) const override {
    return Error{ErrorCode::unsupported, head_.source_name + ": matrices have no times"};
  }
  bool was_cut() const override { return was_cut_; }
  double share() const override { return file_.share(); }

 private:
  Result<void> read_row(std::size_t row) {
    if (fields_.size() != kRows) {
      return Error{ErrorCode::corrupt, fmt::format("{}:{}: {} numbers in a row of a 4x4 matrix", head_.source_name,
                                                   file_.line_number(), fields_.size())};
    }
    for (std::size_t i = 0; i < kRows; ++i) {
      const Cell cell = parse_cell(fields_[i], ' ');
      if (cell.kind == Cell::Kind::text) {
        return Error{ErrorCode::corrupt,
                     fmt::format("{}:{}: '{}' is no number", head_.source_name, file_.line_number(), fields_[i].substr(0, 32))};
      }
      numbers_.at(row * kRows + i) = cell.kind == Cell::Kind::number ? cell.number : kNotMeasured;
    }
    return {};
  }

  FileReader file_;
  std::vector<std::string_view> fields_;
  std::array<double, kRows * kRows> numbers_{};
  bool was_cut_ = false;
};

bool is_finite(const Vec3& point) { return std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z); }

class MatrixRows : public RowMeaning {
 public:
  MatrixRows(std::string device, TrackerUnit unit) : device_(std::move(device)), unit_(unit) {}

  void restart() override { malformed_ = 0; }
  Result<void> read(const TableReader& row, std::vector<Item>& items) override {
    std::array<double, kRows * kRows> m{};
    for (std::size_t i = 0; i < m.size(); ++i) m.at(i) = *row.number(i);
    const double scale = metres_per(unit_);
    const auto rotation =
        wire::quaternion_from_matrix({Vec3{m[0], m[1], m[2]}, Vec3{m[4], m[5], m[6]}, Vec3{m[8], m[9], m[10]}});
    const bool ends_well = m[12] == 0 && m[13] == 0 && m[14] == 0 && m[15] == 1;
    StationPose pose{.position_in_source_m = {m[3] * scale, m[7] * scale, m[11] * scale}};
    if (rotation) pose.source_from_station = *rotation;
    pose.valid = rotation && ends_well && is_finite(pose.position_in_source_m);
    if (!pose.valid) ++malformed_;
    items.push_back({.payload = pose,
                     .status = static_cast<std::uint16_t>(
                         pose.valid ? kStatusOk : static_cast<int>(kStatusMalformed) | kStatusIncomplete)});
    return {};
  }
  std::vector<StreamInfo> streams() const override { return {pose_stream(device_, 1, unit_)}; }
  std::vector<std::string> remarks() const override {
    std::vector<std::string> remarks = {
        fmt::format("4x4 matrices taken as source_from_station, lengths as {}", to_string(unit_)),
        "no times in the file: evenly spaced at the rate"};
    if (malformed_ > 0) remarks.push_back(fmt::format("{} matrices are no rotations", malformed_));
    return remarks;
  }

 private:
  std::string device_;
  TrackerUnit unit_;
  std::uint64_t malformed_ = 0;
};

class LibertyRows : public RowMeaning {
 public:
  using Columns = std::array<std::size_t, 7>;  // w, x, y, z, then the position

  LibertyRows(std::string device, TrackerUnit unit, std::vector<Columns> stations)
      : device_(std::move(device)), unit_(unit), stations_(std::move(stations)), before_(stations_.size()) {}

  void restart() override {
    before_.assign(stations_.size(), {});
    duplicates_ = 0;
    rows_ = 0;
  }
  Result<void> read(const TableReader& row, std::vector<Item>& items) override {
    ++rows_;
    for (std::size_t i = 0; i < stations_.size(); ++i) {
      std::array<double, 7> values{};
      for (std::size_t k = 0; k < values.size(); ++k) {
        const auto number = row.number(stations_[i].at(k));
        if (!number) return number.error();
        values.at(k) = *number;
      }
      const bool is_duplicate = before_[i] == values;
      before_[i] = values;
      items.push_back(to_item(i, values, is_duplicate));
      if (is_duplicate) ++duplicates_;
    }
    return {};
  }
  std::vector<StreamInfo> streams() const override {
    std::vector<StreamInfo> streams;
    for (std::size_t i = 0; i < stations_.size(); ++i) streams.push_back(pose_stream(device_, i + 1, unit_));
    return streams;
  }
  std::vector<std::string> remarks() const override {
    const auto polled = static_cast<double>(rows_ * stations_.size());
    return {fmt::format("lengths taken as {}: say so with --tracker-unit if they are not", to_string(unit_)),
            "quaternions taken as w, x, y, z of source_from_station",
            fmt::format("{:.1f} % of the values repeat the ones before (polled faster than measured) and are flagged duplicate",
                        polled > 0 ? 100 * static_cast<double>(duplicates_) / polled : 0.0)};
  }

 private:
  Item to_item(std::size_t station, const std::array<double, 7>& values, bool is_duplicate) const {
    const double scale = metres_per(unit_);
    const auto rotation = wire::normalised({values[0], values[1], values[2], values[3]});
    StationPose pose{.station = static_cast<std::uint8_t>(station + 1),
                     .position_in_source_m = {values[4] * scale, values[5] * scale, values[6] * scale}};
    if (rotation) pose.source_from_station = *rotation;
    pose.valid = rotation && is_finite(pose.position_in_source_m);
    const int status = (pose.valid ? kStatusOk : kStatusIncomplete) | (is_duplicate ? kStatusDuplicate : kStatusOk);
    return {.stream = station, .payload = pose, .status = static_cast<std::uint16_t>(status)};
  }

  std::string device_;
  TrackerUnit unit_;
  std::vector<Columns> stations_;
  std::vector<std::array<double, 7>> before_;
  std::uint64_t duplicates_ = 0;
  std::uint64_t rows_ = 0;
};

}  // namespace

double metres_per(TrackerUnit unit) {
  switch (unit) {
    case TrackerUnit::inch:
      return 0.0254;
    case TrackerUnit::centimetre:
      return 0.01;
    case TrackerUnit::metre:
      break;
  }
  return 1;
}

Result<std::unique_ptr<TableReader>> open_matrix_table(FileReader file) {
  return std::unique_ptr<TableReader>(std::make_unique<MatrixTable>(std::move(file)));
}

std::unique_ptr<RowMeaning> make_matrix_rows(const std::string& device, TrackerUnit unit) {
  return std::make_unique<MatrixRows>(device, unit);
}

Result<std::unique_ptr<RowMeaning>> make_liberty_rows(const TableReader& table, const std::string& device, TrackerUnit unit,
                                                      std::optional<TimeColumns>& time) {
  const auto found_time = find_time_columns(table.head(), {});
  if (!found_time) return found_time.error();
  time = *found_time;
  std::vector<LibertyRows::Columns> stations;
  for (std::size_t station = 1; station <= kMostStations; ++station) {
    LibertyRows::Columns columns{};
    const std::array names = {fmt::format("w{}", station),    fmt::format("x{}", station),     fmt::format("y{}", station),
                              fmt::format("z{}", station),    fmt::format("loc{}_x", station), fmt::format("loc{}_y", station),
                              fmt::format("loc{}_z", station)};
    const auto first = find_column(table.head(), {"", {names[0]}}, {});
    if (station > 1 && first && !*first) break;
    for (std::size_t k = 0; k < names.size(); ++k) {
      const auto column = require_column(table.head(), {names.at(k), {names.at(k)}}, {});
      if (!column) return column.error();
      columns.at(k) = *column;
    }
    stations.push_back(columns);
  }
  return std::unique_ptr<RowMeaning>(std::make_unique<LibertyRows>(device, unit, std::move(stations)));
}

}  // namespace roseau::recorder
