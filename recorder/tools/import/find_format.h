// What a file is, by looking at its beginning.
#pragma once

#include <string>
#include <string_view>

#include "core/result.h"
#include "recorder/tools/import/import_plan.h"

namespace roseau::recorder {

inline constexpr std::string_view kZipMark = "PK\x03\x04";

/// Never automatic. Error: cannot be read, or it is not sure what it is; says what was seen.
Result<SonicFormat> find_sonic_format(const std::string& path);
Result<TrackerFormat> find_tracker_format(const std::string& path);

/// The same for the first bytes of a file. `name`: for messages.
Result<SonicFormat> sonic_format_of(std::string_view start, const std::string& name);
Result<TrackerFormat> tracker_format_of(std::string_view start, const std::string& name);

}  // namespace roseau::recorder
