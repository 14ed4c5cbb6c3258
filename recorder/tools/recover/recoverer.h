// Recoverer: one pass over a broken file, everything readable into a writer. See recovery.h for what it promises.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "recorder/format/catalog.h"
#include "recorder/format/chunk_builder.h"
#include "recorder/format/chunk_content.h"
#include "recorder/format/writer.h"
#include "recorder/tools/recover/losses.h"
#include "recorder/tools/recover/record_scanner.h"
#include "recorder/tools/recover/recovery.h"

namespace roseau::recorder {

class Recoverer {
 public:
  Recoverer(mcap::Readable& in, mcap::Writable& out, const RecoverOptions& options);

  Result<Recovery> run();

  /// Where the readable part of the file ends: what stands behind is torn, or a summary that is made anew.
  std::uint64_t readable_end() const { return readable_end_; }

 private:
  Result<void> read_records();
  Result<void> take(const mcap::RecordPlace& place);
  Result<void> take_chunk(const mcap::RecordPlace& place);
  Result<void> take_decoded(const mcap::RecordPlace& place, mcap::Record record, std::span<const std::byte> content);
  Result<void> take_attachment(const mcap::RecordPlace& place, const mcap::Attachment& attachment,
                               std::span<const std::byte> content);
  Result<void> take_other(const mcap::RecordPlace& place, const mcap::OtherRecord& record);
  Result<void> take_hole(const Hole& hole);
  Result<void> reject(const mcap::RecordPlace& place, const std::string& reason);
  Result<void> define(const mcap::Schema& schema, const mcap::RecordPlace& place);
  Result<void> define(const mcap::Channel& channel, const mcap::RecordPlace& place);
  Result<bool> ensure_channel(std::uint16_t id);
  Result<bool> ensure_schema(std::uint16_t id);
  Result<void> search_definitions();
  Result<void> copy_chunk(const mcap::RecordPlace& place, mcap::Chunk& chunk, std::span<const std::byte> records);
  Result<void> rebuild_chunk(const mcap::RecordPlace& place, const mcap::Chunk& chunk, const mcap::ChunkContent& content,
                             std::span<const std::byte> records, const std::string& reason);
  Result<std::string> adopt_definitions(const mcap::ChunkContent& content, std::vector<std::uint16_t>& refused);
  struct TornChunk {
    mcap::Chunk head;
    std::uint64_t head_bytes = 0;     // in the file, the record's own head included
    std::uint64_t records_bytes = 0;  // as announced
  };
  Result<std::optional<TornChunk>> read_torn_head(const Hole& hole);
  Result<std::uint64_t> save_torn_chunk(const Hole& hole, LostStretch& stretch);
  Result<void> add_loose(const mcap::Message& message, const mcap::RecordPlace& place);
  Result<void> flush_loose();
  Result<void> end_data(const mcap::RecordPlace& place, const mcap::DataEnd& data_end);
  void read_old_statistics(const mcap::RecordPlace& data_end);
  Result<void> write_what_was_done();
  Result<void> finish();
  void remark(std::string text) { recovery_.remarks.push_back(std::move(text)); }
  void add_input_crc(const mcap::RecordPlace& place, std::span<const std::byte> content);
  void add_input_crc_of_chunk(const mcap::RecordPlace& place, std::span<const std::byte> content, const mcap::Chunk& chunk,
                              std::uint32_t stored_crc);
  bool go_on(std::uint64_t offset);

  mcap::Readable& in_;
  mcap::Writer writer_;
  const RecoverOptions& options_;
  RecordScanner scanner_;
  mcap::Catalog catalog_;
  std::optional<mcap::Catalog> elsewhere_;  // what the whole file defines; read only when something is missing
  Losses losses_;
  Recovery recovery_;
  mcap::ChunkBuilder loose_;  // messages that stand outside of chunks
  std::vector<std::byte> decompressed_;
  bool begun_ = false;
  bool ended_ = false;  // the end of the data section was found
  bool has_final_counters_ = false;
  bool chunk_was_lost_ = false;             // the message indexes that follow are its
  std::optional<std::uint32_t> input_crc_;  // of the data section; nothing when bytes were passed over
  std::uint64_t readable_end_ = 0;
  std::uint64_t next_progress_ = 0;
};

}  // namespace roseau::recorder
