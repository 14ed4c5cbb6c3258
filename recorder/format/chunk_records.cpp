#include "recorder/format/chunk_records.h"

#include <string>

#include "recorder/format/compression.h"
#include "recorder/format/crc32.h"

namespace roseau::mcap {

Result<std::span<const std::byte>> chunk_records(const Chunk& chunk, std::vector<std::byte>& buffer,
                                                 const ReaderOptions& options) {
  const auto compression = compression_from_string(chunk.compression);
  if (!compression) {
    return Error{ErrorCode::unsupported, "the chunk is compressed with '" + chunk.compression +
                                             "', which this program cannot read (it knows zstd and lz4)"};
  }
  if (chunk.uncompressed_size > options.max_chunk_bytes) {
    return Error{ErrorCode::corrupt, "the chunk announces " + std::to_string(chunk.uncompressed_size) + " bytes"};
  }
  std::span<const std::byte> records = chunk.records;
  if (*compression != Compression::none) {
    if (auto done = decompress(*compression, chunk.records, chunk.uncompressed_size, buffer); !done) return done.error();
    records = buffer;
  } else if (chunk.records.size() != chunk.uncompressed_size) {
    return Error{ErrorCode::corrupt, "the chunk announces " + std::to_string(chunk.uncompressed_size) + " bytes and holds " +
                                         std::to_string(chunk.records.size())};
  }
  if (chunk.uncompressed_crc != 0 && crc32(0, records) != chunk.uncompressed_crc) {
    return Error{ErrorCode::corrupt, "the chunk's CRC does not match: its bytes have changed since they were written"};
  }
  return records;
}

Result<void> check_attachment_crc(const Attachment& attachment, std::span<const std::byte> content) {
  if (attachment.crc == 0) return {};
  const auto covered = static_cast<std::size_t>(attachment.data.data() + attachment.data.size() - content.data());
  if (crc32(0, content.first(covered)) != attachment.crc) {
    return Error{ErrorCode::corrupt, "the CRC of attachment '" + attachment.name + "' does not match"};
  }
  return {};
}

}  // namespace roseau::mcap
