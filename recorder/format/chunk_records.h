// The records of one chunk, decompressed and checked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/result.h"
#include "recorder/format/records.h"

namespace roseau::mcap {

/// Bounds on what a file can make a reader allocate, whatever its numbers say. With F the size of the file, a reader holds at
/// most, all in all:
///
///   streamed   min(F, max_record_bytes) + 3 * max_chunk_bytes + 32 * S + 1 MiB
///   indexed    the same + 3 * max_open_bytes
///
/// where S are the bytes of schemas, channels, indexes and other small records (maps and strings take more than the bytes they
/// are made of). Sizes that a chunk announces are not believed: memory grows with what really comes out of it, by doubling
/// (hence the 3).
struct ReaderOptions {
  /// Chunks that would decompress to more are refused: no recorder writes them, a broken file or a zip bomb may.
  std::uint64_t max_chunk_bytes = std::uint64_t{1} << 30U;
  /// Records (chunks as stored, attachments) larger than this are refused.
  std::uint64_t max_record_bytes = std::uint64_t{2} << 30U;
  /// Chunks that overlap in time are open together while messages are read in order. When they hold more than this, stored and
  /// decompressed, further ones are refused until others are used up.
  std::uint64_t max_open_bytes = std::uint64_t{4} << 30U;
};

/// The chunk's records: a view of chunk.records when they are stored as they are, else of `buffer`, which is replaced.
/// Checks sizes and the CRC. Errors: corrupt, unsupported (a compression this program does not know).
Result<std::span<const std::byte>> chunk_records(const Chunk& chunk, std::vector<std::byte>& buffer,
                                                 const ReaderOptions& options);

/// The stored CRC covers the content in front of it; `content` is the record's whole content, that may be longer.
Result<void> check_attachment_crc(const Attachment& attachment, std::span<const std::byte> content);

}  // namespace roseau::mcap
