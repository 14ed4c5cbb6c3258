// Displacement series from files: plain columns of numbers (a strain gauge, an inclinometer, a tracker), or CSV. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "core/sample.h"
#include "recorder/tools/import/record_times.h"
#include "recorder/tools/import/text_table.h"

namespace roseau::recorder {

struct DisplacementFileOptions {
  TableFormat format = TableFormat::automatic;
  /// "x=strain1,y=strain2,time=TIMESTAMP", by name or, without names, by number. Not given: the only column, or the columns
  /// called x and y; two unnamed columns are x and y.
  std::string columns;
  std::optional<double> rate_hz;  // not given: from the time column
  LengthUnit unit = LengthUnit::other;
};

struct DisplacementRecord {
  std::vector<Displacement> samples;  // a missing value makes a sample invalid, with the last good one in its place
  RecordTimes times;                  // one per sample
  std::optional<Duration> begin;      // first time stamp, since 1970 in the stamp's own zone
  bool has_two_axes = false;
  std::uint64_t invalid_samples = 0;
  std::vector<std::string> remarks;
};

/// Error: names the file, and line and column where there is one.
Result<DisplacementRecord> parse_displacement_file(std::string_view text, const std::string& source_name,
                                                   const DisplacementFileOptions& options);

/// "px", "m", "strain", "other".
Result<LengthUnit> length_unit_from_string(std::string_view name);

}  // namespace roseau::recorder
