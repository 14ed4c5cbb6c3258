#include "recorder/tools/import/displacement_file.h"

#include <fmt/format.h>

#include <cmath>

namespace roseau::recorder {

namespace {

const ColumnRequest kX{"x", {"x", "dx", "displacement", "displacement_x", "x_m", "x_px", "strain"}};
const ColumnRequest kY{"y", {"y", "dy", "displacement_y", "y_m", "y_px"}};

const std::vector<std::string> kQuantities = {"x", "y", "time"};

struct Columns {
  std::size_t x = 0;
  std::optional<std::size_t> y;
  std::optional<TimeColumns> time;
};

bool is_unnamed(const TableHead& head) { return head.columns.front() == "1"; }

Result<Columns> find_columns(const TableHead& head, const std::map<std::string, std::string>& map) {
  Columns columns;
  const auto time = find_time_columns(head, map);
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

Result<Displacement> read_sample(const TableReader& rows, const Columns& columns, const Displacement& before) {
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

class DisplacementRows : public RowMeaning {
 public:
  DisplacementRows(Columns columns, LengthUnit unit, StreamInfo info)
      : columns_(std::move(columns)), unit_(unit), info_(std::move(info)) {
    before_.unit = unit;
  }

  void restart() override { before_ = Displacement{.unit = unit_}; }
  Result<void> read(const TableReader& row, std::vector<Item>& items) override {
    const auto sample = read_sample(row, columns_, before_);
    if (!sample) return sample.error();
    before_ = *sample;
    items.push_back({.payload = *sample, .status = static_cast<std::uint16_t>(sample->valid ? kStatusOk : kStatusIncomplete)});
    return {};
  }
  std::vector<StreamInfo> streams() const override { return {info_}; }
  std::vector<std::string> remarks() const override { return {}; }

 private:
  Columns columns_;
  LengthUnit unit_;
  StreamInfo info_;
  Displacement before_;
};

}  // namespace

Result<std::unique_ptr<RowMeaning>> make_displacement_rows(const TableReader& table, const DisplacementFileOptions& options,
                                                           StreamInfo info, std::optional<TimeColumns>& time) {
  const auto map = parse_column_map(options.columns, kQuantities);
  if (!map) return map.error();
  auto columns = find_columns(table.head(), *map);
  if (!columns) return columns.error();
  time = columns->time;
  return std::unique_ptr<RowMeaning>(std::make_unique<DisplacementRows>(std::move(*columns), options.unit, std::move(info)));
}

}  // namespace roseau::recorder
