// A part of a session as a session of its own, for `roseau cut`.
//
// Chunks that lie wholly inside and hold nothing else are copied as they are, not even decompressed and compressed again; those
// at the edges are made anew. Message bytes never change.
//
// What held at the start goes along, though it was said before: the last calibration of each camera, and the targets that the
// operator had set. These messages keep their own times; only their place in the order (log time) is right in front of the cut.
//
// Replaying a cut that begins in mid-run starts afresh: trackers find their features again, clock models and identification
// begin anew at its start. Its results are the same at every replay, but for the first minute or so not those of the whole
// session.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"
#include "recorder/tools/rewrite/session_output.h"
#include "recorder/tools/selection/selection.h"

namespace roseau::recorder {

struct CutReport {
  double begin_s = 0;  // first and last message, from the source's start
  double end_s = 0;
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;
  std::uint64_t chunks_copied = 0;
  std::uint64_t chunks_rebuilt = 0;
  std::uint64_t carried = 0;        // messages from before the start that hold at it
  bool begins_in_mid_run = false;   // something that a replay would have needed was cut off in front
  bool stopped = false;             // by the user: the cut ends early
  std::vector<std::string> damage;  // of the source: what could not be read and is missing
};

/// Errors leave nothing behind. `out` must not exist.
Result<CutReport> cut_session(const std::filesystem::path& in, const std::filesystem::path& out,
                              const SelectionOptions& selection, const ToolProgress& progress = {});

}  // namespace roseau::recorder
