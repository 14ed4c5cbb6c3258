// When the rows of a file were taken: by its own time stamps, or by a rate. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "core/time.h"

namespace roseau::recorder {

/// "2019-07-30 12:00:00.05", with T for the blank, with Z at the end, or without seconds: nanoseconds since 1970 in the
/// stamp's own zone. Also a plain number: seconds. Nothing for anything else.
std::optional<Duration> parse_time_stamp(std::string_view text);

/// "2019-07-30T12:00:00.050"
std::string format_time_stamp(Duration since_1970);

/// How the rows of a file are laid on the time axis.
struct RecordGrid {
  enum class Kind : std::uint8_t {
    by_rate,   // row / rate_hz
    by_stamp,  // the place on the grid of the rate that is nearest to the row's stamp: rounded stamps become regular, holes
               // stay
    as_stamped,
  };
  Kind kind = Kind::by_rate;
  double rate_hz = 0;
  std::uint64_t rows = 0;
  std::optional<Duration> first_stamp;
  std::uint64_t missing_rows = 0;  // by the stamps: places on the grid without a row
};

/// Looks at every row's stamp once and says how the rows are placed. The rate is the stamps' typical one if none is given.
/// Holds kMostIntervals intervals, however long the file is.
class StampSurvey {
 public:
  static constexpr std::size_t kMostIntervals = std::size_t{1} << 16U;

  /// A row with its stamp, or none at all.
  void add(std::optional<Duration> stamp);

  /// Rows so far. Error: no rows, no rate where one is needed, stamps that go back. Messages begin with `source_name`.
  /// Of a grid by_stamp, only a GridCheck tells whether it holds, and its missing rows.
  Result<RecordGrid> finish(std::optional<double> rate_hz, const std::string& source_name);

 private:
  void add_interval(Duration interval);
  void settle_typical();
  double rate_of_stamps() const;

  std::uint64_t rows_ = 0;
  std::uint64_t stamps_ = 0;
  std::optional<Duration> first_;
  Duration last_{0};
  std::optional<std::uint64_t> back_row_;
  bool has_equal_ = false;
  std::vector<Duration> intervals_;
  std::optional<Duration> typical_;
  double steps_ = 0;
};

/// Goes through the stamps once more: are all rows at different places of the grid?
class GridCheck {
 public:
  explicit GridCheck(const RecordGrid& grid) : grid_(grid) {}
  void add(Duration stamp);
  /// The grid, with its missing rows; as_stamped where the stamps are too irregular. Error: they contradict a given rate.
  Result<RecordGrid> finish(bool rate_was_given, const std::string& source_name) const;

 private:
  RecordGrid grid_;
  std::uint64_t row_ = 0;
  double previous_place_ = -1;
  Duration last_{0};
  std::optional<std::uint64_t> collision_;
};

/// Time of a row since the first, on a surveyed grid. Rows come in their order.
class RowPlacer {
 public:
  explicit RowPlacer(const RecordGrid& grid) : grid_(grid) {}
  Duration next(std::optional<Duration> stamp);

 private:
  RecordGrid grid_;
  std::uint64_t row_ = 0;
};

}  // namespace roseau::recorder
