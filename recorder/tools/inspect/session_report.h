// What a session file holds, for `roseau info`. Reads the index and a few chunks per stream, not the pictures: quick on files
// of any size.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/sample.h"
#include "core/time.h"
#include "core/wind_statistics.h"
#include "recorder/format/topics.h"
#include "recorder/tools/inspect/timeline.h"

namespace roseau::recorder {

struct StreamReport {
  StreamInfo info;
  std::string schema;  // message name
  std::uint64_t messages = 0;
  HostTime first;  // sample times
  HostTime last;
  double rate_hz = 0;                      // mean over the stream's own span; 0 with fewer than two messages
  std::optional<StreamCounters> counters;  // as the recorder left them
  std::string unreadable;                  // why this program cannot read the stream; empty: it can
};

struct WindReport {
  std::string topic;
  double north_offset_deg = 0;
  WindAxes axes = WindAxes::gill_spar;
  WindStatistics statistics;
};

struct SessionReport {
  std::filesystem::path path;
  std::uint64_t bytes = 0;
  bool is_complete = true;
  std::vector<std::string> damage;  // what is lost, one sentence each
  mcap::SessionInfo session;
  HostTime begin;  // order times of the first and last message
  HostTime end;
  std::vector<StreamReport> streams;  // by topic
  std::vector<WindReport> winds;
  std::vector<std::pair<std::string, std::uint64_t>> attachments;  // name, bytes
  Timeline timeline;
};

/// `slices`: of the timeline. The wind's statistics need every wind sample: they are left out where these are spread over more
/// than some hundred megabytes.
Result<SessionReport> inspect_session(const std::filesystem::path& path, std::size_t slices = 60);

std::string to_text(const SessionReport& report);
std::string to_json(const SessionReport& report);

}  // namespace roseau::recorder
