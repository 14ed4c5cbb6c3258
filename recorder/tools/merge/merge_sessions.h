// Several files into one, in order of corrected time, for `roseau merge`: the parts of a session that was split, and the
// sessions of several hosts.
//
// Times of other hosts are moved onto the first file's axis (clock_shift.h), in the file's own fields and in the messages. What
// the messages said before is kept in their headers: host_arrival_time and host_sample_time. Messages of other programs are not
// rewritten: only their places in the order move. Log times are made strictly increasing.
//
// Topics that another host has too get the name of their host in front, except the first host's, so that its configuration fits
// the merged file. Attachments and metadata of the others are kept under "HOST/name".
//
// Parts may overlap (two cuts of one session): a message that was there already, byte by byte at the same time, is left out and
// counted.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/result.h"
#include "recorder/tools/merge/merge_plan.h"
#include "recorder/tools/rewrite/session_output.h"

namespace roseau::recorder {

struct MergeReport {
  struct Input {
    std::filesystem::path path;
    std::string host;
    std::size_t group = 0;  // files with the same number are parts of one session
    std::string moved_by;   // onto the first file's axis; empty: not
    std::uint64_t messages = 0;
    std::uint64_t duplicates = 0;  // left out
  };
  std::vector<Input> inputs;
  std::map<std::string, std::string> renamed;  // "file topic" -> topic
  double duration_s = 0;
  std::uint64_t messages = 0;
  std::uint64_t duplicates = 0;
  std::uint64_t bytes = 0;
  bool stopped = false;             // by the user: the file ends early
  std::vector<std::string> damage;  // of the sources: what could not be read and is missing
};

/// Errors leave nothing behind. `out` must not exist.
Result<MergeReport> merge_sessions(const std::vector<std::filesystem::path>& files, const std::filesystem::path& out,
                                   const MergeOptions& options = {}, const ToolProgress& progress = {});

}  // namespace roseau::recorder
