// Checking a session file to the last byte, for `roseau verify`. Any MCAP file can be checked; what roseau's own sessions
// promise beyond the format is checked where they promise it.
//
//   checksums   every chunk's and attachment's, the data section's, the summary's; a file without the data section's CRC is
//               named, because then a byte outside of chunks (metadata, say, which has no CRC of its own) may change unseen
//   structure   record order, schemas before channels before messages, ids, what may stand in a chunk, the end of the file and
//               bytes behind it
//   counts      message indexes against the chunks' content, chunk times, chunk, attachment and metadata indexes, statistics,
//               summary offsets, the recorder's own counters
//   streams     order of the inputs' log times, holes and repetitions in sequence numbers
//   payloads    every message parses: of known kinds as replay would, of others by the schema in the file (protobuf, JSON)
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/result.h"
#include "recorder/format/chunk_records.h"
#include "recorder/format/io.h"

namespace roseau::recorder {

struct StreamVerification {
  std::string topic;
  std::uint64_t messages = 0;
  std::uint64_t payloads_checked = 0;
  std::string unchecked;  // why payloads were not checked; empty: they were
  // What is no fault of the file:
  std::uint64_t jumps = 0;     // places where the sequence number jumps forward
  std::uint64_t missing = 0;   // numbers left out there
  std::uint64_t repeated = 0;  // messages with the same number and log time as one before
  std::uint64_t dropped = 0;   // as the recorder counted
  std::uint64_t gaps = 0;      // holes in the device's numbers, as the sequencer counted
};

struct Verification {
  std::uint64_t bytes = 0;
  std::uint64_t messages = 0;
  std::uint64_t chunks = 0;
  std::uint64_t attachments = 0;
  std::uint64_t crcs_checked = 0;
  bool is_complete = false;  // read to the closing magic
  /// What is wrong, in words that say where and what is lost. The first hundred; `problem_count` counts all.
  std::vector<std::string> problems;
  std::uint64_t problem_count = 0;
  /// What could not be checked, and why.
  std::vector<std::string> remarks;
  std::vector<StreamVerification> streams;  // by topic
};

struct VerifyOptions {
  std::function<bool(double share)> progress;  // called now and then; false: stop
  mcap::ReaderOptions reader;
};

/// An Error only when the file cannot be opened, is no MCAP file at all, cannot be read further (the disk), or was stopped.
Result<Verification> verify_session(const std::filesystem::path& path, const VerifyOptions& options = {});
Result<Verification> verify_session(mcap::Readable& in, const VerifyOptions& options = {});

std::string to_text(const Verification& found);
std::string to_json(const Verification& found);

}  // namespace roseau::recorder
