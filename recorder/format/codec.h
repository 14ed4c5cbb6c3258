// MCAP records <-> bytes. Pure; little-endian whatever the machine (checked at compile time to be the machine's own order).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "recorder/format/records.h"

namespace roseau::mcap {

/// Appends the whole record, opcode and length included, to `out`. An Attachment's CRC is computed here.
void encode(const Header& record, std::vector<std::byte>& out);
void encode(const Footer& record, std::vector<std::byte>& out);
void encode(const Schema& record, std::vector<std::byte>& out);
void encode(const Channel& record, std::vector<std::byte>& out);
void encode(const Message& record, std::vector<std::byte>& out);
void encode(const MessageIndex& record, std::vector<std::byte>& out);
void encode(const ChunkIndex& record, std::vector<std::byte>& out);
void encode(const Attachment& record, std::vector<std::byte>& out);
void encode(const AttachmentIndex& record, std::vector<std::byte>& out);
void encode(const Statistics& record, std::vector<std::byte>& out);
void encode(const Metadata& record, std::vector<std::byte>& out);
void encode(const MetadataIndex& record, std::vector<std::byte>& out);
void encode(const SummaryOffset& record, std::vector<std::byte>& out);
void encode(const DataEnd& record, std::vector<std::byte>& out);
void encode(const OtherRecord& record, std::vector<std::byte>& out);

/// The head of a message record whose data (of `data_bytes` bytes; record.data is not looked at) follows from elsewhere.
inline constexpr std::size_t kMessageHeadBytes = 9 + 2 + 4 + 8 + 8;
void encode_message_head(const Message& record, std::uint64_t data_bytes, std::vector<std::byte>& out);

/// Everything of a chunk record up to its records, whose stored (compressed) bytes follow from elsewhere.
void encode_chunk_head(const Chunk& record, std::uint64_t stored_bytes, std::vector<std::byte>& out);

/// The Metadata layout under a private opcode: what roseau's checkpoints are made of.
void encode_private(Opcode opcode, const Metadata& record, std::vector<std::byte>& out);
Result<Metadata> decode_metadata(std::span<const std::byte> content);

/// One record's content, without opcode and length. Views in the result point into `content`. Unknown trailing bytes are
/// skipped, an unknown opcode gives an OtherRecord. CRCs are not checked here. Errors: corrupt or truncated, and say what.
Result<Record> decode(std::uint8_t opcode, std::span<const std::byte> content);

/// What footer.summary_crc covers of the footer itself: opcode, length and the two offsets.
std::vector<std::byte> footer_prefix(const Footer& record);

/// Opcode and length at the front of `bytes` (at least kRecordHeadBytes).
struct RecordHead {
  std::uint8_t opcode = 0;
  std::uint64_t content_bytes = 0;
};
RecordHead decode_head(std::span<const std::byte> bytes);

/// "chunk", "message index", ...; "record 0x9A" for others.
std::string name_of(std::uint8_t opcode);

}  // namespace roseau::mcap
