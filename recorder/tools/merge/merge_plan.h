// What a merge does with each file: whose clock it has, which session it is a part of, what its topics are called afterwards.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "recorder/format/indexed_reader.h"
#include "recorder/format/topics.h"
#include "recorder/tools/merge/clock_shift.h"

namespace roseau::recorder {

struct MergeOptions {
  /// By file: what stands in front of its topics that collide with another host's, instead of the host's name. An empty one
  /// says nothing.
  std::vector<std::string> prefixes;
};

struct MergeInput {
  std::filesystem::path path;
  std::unique_ptr<mcap::IndexedReader> reader;
  mcap::SessionInfo info;
  std::string host;          // name in front of colliding topics: unique among hosts
  std::size_t group = 0;     // files with the same number are parts of one session: same clock, same streams
  CivilOffset civil_offset;  // of its host
  bool is_moved = false;     // onto the first file's axis
  std::string moved_by;      // in words, for the report; empty: not moved
  std::map<std::uint16_t, std::uint16_t> channel_of;  // id here -> id in the merged file
};

struct MergePlan {
  std::vector<MergeInput> inputs;
  std::vector<mcap::Schema> schemas;
  std::vector<mcap::Channel> channels;
  std::map<std::string, std::string> renamed;  // "file topic" -> topic in the merged file
};

/// Opens the files. Errors: unreadable, of a newer roseau, or hosts whose clocks nobody can compare.
Result<MergePlan> plan_merge(const std::vector<std::filesystem::path>& files, const MergeOptions& options);

}  // namespace roseau::recorder
