// Logs of what an instrument sent, line by line, with whatever the logger noted about the time.
//
//   2024-12-31 23:59:59.95 $WIMWV,...      date and time in front (T, comma, semicolon or tab will do too, and [ ])
//   23:59:59.95,S2  02.222 D ...           time of day
//   1436000000.25 $WIMWV,...               seconds since 1970
//   650,39.252422,-119.878113,17503900,70721,S2  02.222 D ...     milliseconds since the logger's start, GPS latitude and
//                                          longitude (1000: no fix), GPS time hhmmsscc, GPS date ddmmyy
//   $WIMWV,...                             nothing
//
// The last but one also as the blocks of 16384 bytes that a Teensy wrote: uint32 count (at most 110), count records of 148
// bytes (uint32 milliseconds, float32 latitude and longitude, uint32 time, uint32 date, 128 bytes of text), padding.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "core/time.h"
#include "recorder/tools/import/byte_source.h"

namespace roseau::recorder {

struct LogEntry {
  struct Stamp {
    Duration time{0};  // since 1970, or since midnight
    bool is_time_of_day = false;
  };

  std::string bytes;  // as the instrument sent them; the line's end, which loggers change or take away, is CR LF again
  std::optional<Stamp> stamp;
  std::optional<std::uint32_t> millis;
  std::optional<Duration> gps;  // since 1970
  bool has_fix = false;
};

class LogReader {
 public:
  virtual ~LogReader() = default;
  virtual Result<void> rewind() = 0;
  /// False at the end. Error: names the file and the place.
  virtual Result<bool> next(LogEntry& entry) = 0;
  virtual double share() const = 0;
  /// The file ended in the middle of a record, which was left out.
  virtual bool was_cut() const = 0;
};

std::unique_ptr<LogReader> open_text_log(FileReader file);

/// The files of one logger, in the order of their names.
Result<std::unique_ptr<LogReader>> open_block_log(std::vector<std::string> paths);

/// True: this could be the beginning of a file of blocks.
bool looks_like_block_log(std::string_view start);

/// Takes what a logger put in front of `line` off it, into `entry`.
void take_log_prefix(std::string_view& line, LogEntry& entry);

/// hhmmsscc and ddmmyy, as numbers; nothing for what is no time.
std::optional<Duration> parse_gps_time(std::uint32_t time, std::uint32_t date);

}  // namespace roseau::recorder
