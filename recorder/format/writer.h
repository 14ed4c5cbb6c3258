// Writer: one MCAP file, from the first magic to the last, with every CRC the format has.
//
// begin, then any records, then finish. Nothing is held back between calls: what a call was given has been handed to the
// Writable when it returns. A call that fails leaves the writer as if it had not been made, so that finish may still give a
// whole file (io.h says when). One thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <vector>

#include "core/result.h"
#include "recorder/format/chunk_builder.h"
#include "recorder/format/chunk_content.h"
#include "recorder/format/io.h"
#include "recorder/format/records.h"

namespace roseau::mcap {

/// Which optional parts a file gets. All of them, except where a test asks for less.
struct WriterOptions {
  bool message_indexes = true;  // after each chunk
  bool statistics = true;       // the rest: in the summary
  bool repeat_schemas = true;
  bool repeat_channels = true;
  bool attachment_indexes = true;
  bool metadata_indexes = true;
  bool chunk_indexes = true;
  bool summary_offsets = true;
};

class Writer {
 public:
  explicit Writer(Writable& out, WriterOptions options = {}) : out_(out), options_(options) {}

  Result<void> begin(const Header& header);

  /// A schema must come before the first channel that uses it, a channel before its first message: here, or in a chunk.
  Result<void> write(const Schema& schema);
  Result<void> write(const Channel& channel);
  Result<void> write(const Message& message);  // outside of any chunk
  Result<void> write(const Attachment& attachment);
  Result<void> write(const Metadata& metadata);
  Result<void> write_private(Opcode opcode, const Metadata& content);
  /// Writes the chunk and its message indexes with one append. A compressed chunk that did not shrink is stored as it is.
  Result<void> write(const ChunkBuilder& chunk);
  /// A record of a kind this program does not know, or a private one, as it stands in another file.
  Result<void> write(const OtherRecord& record);
  /// A chunk as it stands in another file, not compressed anew. `content` is what its records hold (chunk_content): times,
  /// message indexes and counts are taken from there. `stored_crc` is the CRC of chunk.records as they are stored.
  Result<void> copy(const Chunk& chunk, std::uint32_t stored_crc, const ChunkContent& content);

  /// Data end, summary, footer, magic.
  Result<void> finish();

  std::uint64_t bytes_written() const { return position_; }
  /// What finish() would add, about: never less, but for what is written in between.
  std::uint64_t end_bytes() const { return end_bytes_; }
  const Statistics& statistics() const { return statistics_; }

 private:
  using Parts = std::vector<std::span<const std::byte>>;

  void remember(const Schema& schema);
  void remember(const Channel& channel);
  void count_messages(std::uint16_t channel_id, std::uint64_t count, std::uint64_t start_ns, std::uint64_t end_ns);
  struct StoredChunk {
    Chunk record;
    std::uint64_t bytes = 0;  // as stored
    std::uint32_t crc = 0;    // of these
  };
  Result<StoredChunk> store(const ChunkBuilder& chunk);
  Result<void> append_chunk(const StoredChunk& stored, const std::map<std::uint16_t, MessageIndex>& indexes);
  void count(const StoredChunk& stored, const std::vector<Schema>& schemas, const std::vector<Channel>& channels,
             const std::map<std::uint16_t, MessageIndex>& indexes);
  template <class T>
  Result<void> write_record(const T& record);
  Result<void> append(std::span<const std::byte> bytes);
  template <class T>
  void add_group(Opcode opcode, const std::vector<T>& records, bool wanted, std::vector<std::byte>& summary,
                 std::vector<SummaryOffset>& offsets) const;
  std::vector<std::byte> encode_message_indexes(const std::map<std::uint16_t, MessageIndex>& indexes, std::uint64_t position,
                                                ChunkIndex& index) const;

  Writable& out_;
  WriterOptions options_;
  std::uint64_t position_ = 0;
  std::uint32_t data_crc_ = 0;
  std::uint64_t end_bytes_ = 1024;  // statistics, offsets, footer: below that, but for the counts of channels
  std::vector<std::byte> scratch_;  // reused: small records and chunk heads
  std::vector<std::byte> compressed_;
  Parts parts_;

  Statistics statistics_;
  std::vector<Schema> schemas_;    // in order of first appearance
  std::vector<Channel> channels_;  // the same
  std::set<std::uint16_t> schema_ids_;
  std::set<std::uint16_t> channel_ids_;
  std::vector<AttachmentIndex> attachment_indexes_;
  std::vector<MetadataIndex> metadata_indexes_;
  std::vector<ChunkIndex> chunk_indexes_;
};

}  // namespace roseau::mcap
