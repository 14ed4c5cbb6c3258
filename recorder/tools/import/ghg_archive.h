// LI-COR's .ghg: a zip archive of NAME.data, NAME.metadata and others. The .data is read as it lies, unpacked on the way.
#pragma once

#include <memory>
#include <string>

#include "recorder/tools/import/byte_source.h"

namespace roseau::recorder {

/// Error: no zip archive, or not exactly one .data beside the biomet's ("...-biomet.data").
Result<std::unique_ptr<ByteSource>> open_ghg_archive(const std::string& path);

}  // namespace roseau::recorder
