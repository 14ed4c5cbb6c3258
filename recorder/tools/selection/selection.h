// Which part of a session: what --from, --to, --for, --topic and --without mean, the same for every tool that takes a part.
//
// Times are those of the file's order (log time: when an input arrived, a result came out). A part holds from <= time < to, so
// that two parts that meet share nothing.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "core/time.h"
#include "recorder/format/file_index.h"

namespace roseau::recorder {

/// A time as people give it:
///   12.5, 1e3             seconds from the session's first message
///   2026-11-22T15:46:08Z  civil time (civil_time.h: parse_utc)
///   123456789012345       host monotonic time in nanoseconds: a whole number of at least 10^9, or with "ns" behind it
struct TimePoint {
  enum class Axis : std::uint8_t { session, utc, host };
  Axis axis = Axis::session;
  Duration since{0};  // the session's start, 1970, or the host's start
};
Result<TimePoint> parse_time_point(std::string_view text);

/// As on the command line.
struct SelectionOptions {
  std::optional<std::string> from;  // first time wanted
  std::optional<std::string> to;    // first time no longer wanted
  std::optional<double> seconds;    // instead of one of them: how long
  std::vector<std::string> topics;  // globs: * stands for anything, ? for one character, [ab] for one of these; none: all
  std::vector<std::string> without;

  bool has_times() const { return from || to || seconds; }
};

/// The part, as a file knows it.
struct Selection {
  std::uint64_t first_time_ns = 0;                                         // log time
  std::uint64_t last_time_ns = std::numeric_limits<std::uint64_t>::max();  // log time, still wanted
  std::vector<std::uint16_t> channels;                                     // ids, sorted

  bool holds_time(std::uint64_t log_time_ns) const { return log_time_ns >= first_time_ns && log_time_ns <= last_time_ns; }
  bool holds_channel(std::uint16_t id) const;
};

bool matches(const std::string& glob, const std::string& topic);

/// Errors, in words for the user: a time that is none, civil time in a session that does not know it, an empty or foreign span,
/// a glob that no topic matches.
Result<Selection> select(const SelectionOptions& options, const mcap::FileIndex& index,
                         std::optional<Duration> utc_minus_host_time);

}  // namespace roseau::recorder
