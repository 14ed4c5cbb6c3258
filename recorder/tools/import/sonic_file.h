// Anemometer records from tables: CSV with named columns, TOA5, TOB1, GHG.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/result.h"
#include "recorder/tools/import/table.h"
#include "recorder/tools/import/table_feed.h"

namespace roseau::recorder {

/// m/s in the instrument's own axes; a missing u or v makes a sample invalid. `info`: what the stream is, without what the file
/// tells. `time` is set to where the rows' times stand. Error: a column that is missing, with those that there are.
Result<std::unique_ptr<RowMeaning>> make_wind_rows(const TableReader& table, const SonicFileOptions& options, StreamInfo info,
                                                   std::optional<TimeColumns>& time);

}  // namespace roseau::recorder
