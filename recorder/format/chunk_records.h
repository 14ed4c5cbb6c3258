// The records of one chunk, decompressed and checked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/result.h"
#include "recorder/format/records.h"

namespace roseau::mcap {

struct ReaderOptions {
  /// Chunks that would decompress to more are refused: no recorder writes them, a broken file may.
  std::uint64_t max_chunk_bytes = std::uint64_t{1} << 30U;
};

/// The chunk's records: a view of chunk.records when they are stored as they are, else of `buffer`, which is replaced.
/// Checks sizes and the CRC. Errors: corrupt, unsupported (a compression this program does not know).
Result<std::span<const std::byte>> chunk_records(const Chunk& chunk, std::vector<std::byte>& buffer,
                                                 const ReaderOptions& options);

/// The stored CRC covers the content in front of it; `content` is the record's whole content, that may be longer.
Result<void> check_attachment_crc(const Attachment& attachment, std::span<const std::byte> content);

}  // namespace roseau::mcap
