// RecordReader: the sequence of records in a file, or in a chunk's bytes, without looking into them. What all other readers
// stand on; it never reads or allocates more than the file holds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/result.h"
#include "recorder/format/chunk_records.h"
#include "recorder/format/codec.h"
#include "recorder/format/io.h"

namespace roseau::mcap {

struct RecordPlace {
  std::uint8_t opcode = 0;
  std::uint64_t offset = 0;         // of the opcode
  std::uint64_t content_bytes = 0;  // whole: checked against the end
  std::uint64_t content_offset() const { return offset + kRecordHeadBytes; }
  std::uint64_t end() const { return content_offset() + content_bytes; }
};

class RecordReader {
 public:
  /// Records in [offset, end) of `in`. Records larger than `max_record_bytes` can be passed over and not be read.
  RecordReader(Readable& in, std::uint64_t offset, std::uint64_t end,
               std::uint64_t max_record_bytes = ReaderOptions{}.max_record_bytes)
      : in_(in), position_(offset), end_(end), max_record_bytes_(max_record_bytes) {}

  /// The next record, passed over without reading its content; nothing at the end. Errors: truncated (the bytes end in the
  /// middle of a record), corrupt (no record can stand here: opcode 0), or of reading. After an Error there is no next record.
  Result<std::optional<RecordPlace>> next();

  /// `size` bytes of the file, valid until the next call of anything. Errors: unsupported (too many at once), or of reading.
  Result<std::span<const std::byte>> bytes(std::uint64_t offset, std::uint64_t size);
  Result<std::span<const std::byte>> content(const RecordPlace& place) {
    return bytes(place.content_offset(), place.content_bytes);
  }
  Result<Record> decode(const RecordPlace& place);

  /// Where the next record would begin.
  std::uint64_t position() const { return position_; }

 private:
  Readable& in_;
  std::uint64_t position_;
  std::uint64_t end_;
  std::uint64_t max_record_bytes_;
  // Small records come in great number: they are read through a window instead of one by one.
  std::vector<std::byte> window_;
  std::uint64_t window_offset_ = 0;
  std::vector<std::byte> large_;
};

/// The same over bytes in memory (the records of a chunk). `place.offset` counts from the start of the bytes.
Result<std::optional<RecordPlace>> next_record(std::span<const std::byte> records, std::uint64_t& position);

}  // namespace roseau::mcap
