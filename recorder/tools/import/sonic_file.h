// Anemometer records from files: CSV with named columns, TOA5. Pure.
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

enum class TemperatureUnit : std::uint8_t {
  automatic,  // by the file's units, else kelvin if the values lie about 150 or more
  celsius,
  kelvin,
};
Result<TemperatureUnit> temperature_unit_from_string(std::string_view name);

struct SonicFileOptions {
  TableFormat format = TableFormat::automatic;
  /// "u=U,v=V,w=W,t=T_SONIC,c=SOS,status=DIAG,time=TIMESTAMP"; only what the usual names do not find needs saying.
  /// status: any number but 0 means that the instrument flags the row.
  std::string columns;
  std::optional<double> rate_hz;  // not given: from the time column
  TemperatureUnit temperature_unit = TemperatureUnit::automatic;
};

struct SonicRecord {
  std::vector<WindSample> samples;  // m/s in the instrument's own axes; a missing u or v makes a sample invalid
  RecordTimes times;                // one per sample
  std::optional<Duration> begin;    // first time stamp, since 1970 in the stamp's own zone
  std::uint64_t invalid_samples = 0;
  std::vector<std::string> remarks;  // for people: which column served for what, what was doubtful
};

/// Error: names the file, and line and column where there is one.
Result<SonicRecord> parse_sonic_file(std::string_view text, const std::string& source_name, const SonicFileOptions& options);

}  // namespace roseau::recorder
