// When the rows of a file were taken: by its own time stamps, or by a rate. Pure.
#pragma once

#include <cstddef>
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

struct RecordTimes {
  std::vector<Duration> since_first;  // one per row, strictly increasing
  double rate_hz = 0;
  std::size_t missing_rows = 0;  // by the stamps: places on the grid without a row
};

/// With stamps (one per row, or none at all): each row goes to the place on the grid of the rate that is nearest to its stamp,
/// so that rounded stamps become regular and holes stay holes; the rate is their typical one if none is given. Stamps too
/// irregular for any grid are taken as they are. Without stamps, or with several rows sharing one: row / rate_hz.
/// Error: no rate where one is needed, stamps that go back, or a rate that the stamps contradict. Messages begin with
/// `source_name`.
Result<RecordTimes> place_records(std::size_t row_count, const std::vector<Duration>& stamps, std::optional<double> rate_hz,
                                  const std::string& source_name);

}  // namespace roseau::recorder
