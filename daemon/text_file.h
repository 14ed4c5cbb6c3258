// Small files read whole: configurations, scenes, site sheets.
#pragma once

#include <filesystem>
#include <string>

#include "core/result.h"

namespace roseau::daemon {

/// The file's bytes. Error (not_found) in words that name the file.
Result<std::string> read_text_file(const std::filesystem::path& path);

}  // namespace roseau::daemon
