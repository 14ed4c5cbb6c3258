// Displacement series from tables: plain columns of numbers (a strain gauge, an inclinometer, a tracker), or CSV.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/result.h"
#include "recorder/tools/import/table.h"
#include "recorder/tools/import/table_feed.h"

namespace roseau::recorder {

/// A missing value makes a sample invalid, with the last good one in its place. `info`: what the stream is, without what the
/// file tells. `time` is set to where the rows' times stand. Error: a column that is missing, with those that there are.
Result<std::unique_ptr<RowMeaning>> make_displacement_rows(const TableReader& table, const DisplacementFileOptions& options,
                                                           StreamInfo info, std::optional<TimeColumns>& time);

}  // namespace roseau::recorder
