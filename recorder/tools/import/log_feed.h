// A log of what an instrument sent as a feed of raw bytes: the same that a driver would have recorded.
#pragma once

#include <memory>
#include <string>

#include "recorder/tools/import/import_feed.h"
#include "recorder/tools/import/log_reader.h"

namespace roseau::recorder {

/// Reads the log twice: to learn its times and what it holds, and to hand it on. Error: no line that the instrument could have
/// sent, or no times and no rate; names the file.
Result<std::unique_ptr<ImportFeed>> make_trisonica_feed(std::unique_ptr<LogReader> log, const ImportPlan::Sonic& sonic);
Result<std::unique_ptr<ImportFeed>> make_nmea_feed(std::unique_ptr<LogReader> log, const ImportPlan::Sonic& sonic);

/// Bytes of a FASTRAK as a terminal program saved them: text or binary, items 2,4,1 or 2,11,0, whichever more can be read as.
/// There are no times: records follow each other evenly at the rate.
Result<std::unique_ptr<ImportFeed>> make_fastrak_feed(FileReader file, const ImportPlan::Tracker& tracker);

}  // namespace roseau::recorder
