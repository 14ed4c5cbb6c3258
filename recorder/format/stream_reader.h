// StreamReader: every record of a file in the order in which it stands there, chunks opened in place, every CRC checked. Needs
// no summary, so it reads a file that was cut off at any byte up to its last whole record or chunk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "recorder/format/catalog.h"
#include "recorder/format/chunk_records.h"
#include "recorder/format/io.h"
#include "recorder/format/record_reader.h"
#include "recorder/format/records.h"

namespace roseau::mcap {

class StreamReader {
 public:
  /// `in` must outlive the reader.
  explicit StreamReader(Readable& in, ReaderOptions options = {});

  /// The next record; nothing at the end, whole or cut (see complete()). Chunk and MessageIndex records are not handed out: the
  /// records inside chunks are. Views in the record are valid until the next call.
  ///
  /// An Error says what is wrong and where (byte offset). Damage is contained: calling again goes on behind the damaged record
  /// or chunk, until can_continue() is false.
  Result<std::optional<Record>> next();

  bool can_continue() const { return !ended_; }

  /// The file was read to its closing magic. False after the end of a file that was cut off: ending() then says where.
  bool complete() const { return complete_; }
  const std::string& ending() const { return ending_; }

  const Catalog& catalog() const { return catalog_; }

 private:
  Result<void> check_magic();
  Result<std::optional<Record>> end_here(const Error& error);
  Result<std::optional<Record>> next_in_chunk();
  Result<std::optional<Record>> take(const RecordPlace& place);
  Result<void> open_chunk(const RecordPlace& place, const Chunk& chunk);
  Result<void> check(const Record& record, const RecordPlace& place, std::span<const std::byte> content);
  Result<void> check_footer(const Footer& footer, const RecordPlace& place);
  void update_crc(const RecordPlace& place, std::span<const std::byte> content);

  Readable& in_;
  ReaderOptions options_;
  RecordReader records_;
  Catalog catalog_;
  bool begun_ = false;
  bool ended_ = false;
  bool complete_ = false;
  std::string ending_;

  std::uint32_t section_crc_ = 0;    // of the data section, then of the summary, up to here
  std::uint64_t summary_start_ = 0;  // 0: still in the data section

  std::vector<std::byte> chunk_buffer_;
  std::span<const std::byte> chunk_;  // empty: not in a chunk
  std::uint64_t chunk_position_ = 0;
  std::uint64_t chunk_offset_ = 0;
};

/// The eight bytes at the start of a file. Errors: corrupt (not MCAP), unsupported (another major version), truncated.
Result<void> check_opening_magic(Readable& in);

}  // namespace roseau::mcap
