// FileIndex: where everything is in a file. Read from its summary; where there is none (the file was cut off), where it is
// damaged or where it does not say enough, made by walking over the file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "recorder/format/catalog.h"
#include "recorder/format/chunk_records.h"
#include "recorder/format/io.h"
#include "recorder/format/records.h"

namespace roseau::mcap {

/// A stretch of the file that holds messages: a chunk, or a run of records outside of any chunk.
struct MessageBlock {
  std::uint64_t offset = 0;  // of the Chunk record, or of the run's first record
  std::uint64_t length = 0;
  std::uint64_t start_time_ns = 0;
  std::uint64_t end_time_ns = 0;
  bool is_chunk = true;
  /// Sorted channel ids; nothing when it is not known which channels it holds.
  std::optional<std::vector<std::uint16_t>> channels;
};

/// A record with an opcode that MCAP leaves to programs. Found only when walking over the file.
struct PrivateRecord {
  std::uint8_t opcode = 0;
  std::uint64_t offset = 0;
  std::uint64_t content_bytes = 0;
};

struct FileIndex {
  Header header;
  Catalog catalog;
  Statistics statistics;             // the file's own, or counted
  std::vector<MessageBlock> blocks;  // in order of (start time, offset)
  std::vector<AttachmentIndex> attachments;
  std::vector<MetadataIndex> metadata;
  std::vector<PrivateRecord> private_records;

  /// The file ends as it should. False: it was cut off or damaged, and `damage` says where and what is lost, one sentence each.
  bool complete = true;
  std::vector<std::string> damage;
};

/// Reads or makes the index. A cut or damaged file gives an index of what can be read, and says so; an Error only when nothing
/// can: not an MCAP file, or the disk failed.
Result<FileIndex> read_file_index(Readable& in, const ReaderOptions& options);

/// Whether the file was closed properly: it ends with a footer, and the summary's CRC matches. Quick on files of any size. The
/// Error says what is missing.
Result<void> check_ending(Readable& in);

}  // namespace roseau::mcap
