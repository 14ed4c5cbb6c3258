// Poses of magnetic trackers from tables: 4x4 matrices as text, and host logs of a Polhemus Liberty.
//
//   matrices   four lines of four numbers and an empty line per sample: the rotation and, in the last column, the position of
//              the station in the axes of its source; last line 0 0 0 1. One station.
//   liberty    CSV: Time (seconds since 1970), w1,x1,y1,z1, ... w2,x2,y2,z2, ..., loc1_x,loc1_y,loc1_z, ...: quaternion (scalar
//              first, as the tracker sends it: source_from_station) and position of each station. Hosts poll faster than the
//              tracker measures: a station's values that are exactly those of the row before are flagged as duplicates.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/result.h"
#include "recorder/tools/import/byte_source.h"
#include "recorder/tools/import/import_plan.h"
#include "recorder/tools/import/table_feed.h"

namespace roseau::recorder {

double metres_per(TrackerUnit unit);

/// Matrices as a table of 16 columns. Error: no numbers, or rows of other than four, naming the line.
Result<std::unique_ptr<TableReader>> open_matrix_table(FileReader file);

/// A matrix whose rotation is none (not square by more than 0.05) is a sample flagged malformed and not valid.
std::unique_ptr<RowMeaning> make_matrix_rows(const std::string& device, TrackerUnit unit);

/// `time` is set to where the rows' times stand. Error: no columns w1, ... for a station.
Result<std::unique_ptr<RowMeaning>> make_liberty_rows(const TableReader& table, const std::string& device, TrackerUnit unit,
                                                      std::optional<TimeColumns>& time);

}  // namespace roseau::recorder
