// SummaryCheck: what the data section holds, collected while it is read, and whether the summary says the same.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "recorder/format/catalog.h"
#include "recorder/format/chunk_content.h"
#include "recorder/format/record_reader.h"
#include "recorder/format/records.h"
#include "recorder/tools/inspect/problems.h"
#include "recorder/tools/inspect/stream_check.h"

namespace roseau::recorder {

class SummaryCheck {
 public:
  explicit SummaryCheck(Problems& problems) : problems_(problems) {}

  // The data section.
  /// `content` null: the chunk does not read.
  void see_chunk(const mcap::RecordPlace& place, const mcap::Chunk& chunk, const mcap::ChunkContent* content);
  void see_message_index(const mcap::RecordPlace& place, const mcap::MessageIndex& index);
  void see_other(const mcap::RecordPlace& place, const mcap::Record& record);
  /// What follows is no message index of the last chunk any more.
  void end_chunk();

  // The summary.
  void see_summary(const mcap::RecordPlace& place, const mcap::Record& record);
  void finish(const mcap::Footer& footer, const StreamCheck& streams, const mcap::Catalog& catalog);

  std::uint64_t chunks() const { return chunks_.size(); }

 private:
  struct ChunkFacts {
    mcap::ChunkIndex expected;
    std::optional<std::map<std::uint16_t, mcap::MessageIndex>> indexes;  // of its content; nothing when it does not read
    bool is_indexed = false;                                             // the summary lists it
  };
  void check_chunk_index(const mcap::ChunkIndex& index);
  void check_statistics(const StreamCheck& streams, const mcap::Catalog& catalog);
  void check_offsets(const mcap::Footer& footer);
  void check_repeated(const StreamCheck& streams, const mcap::Catalog& catalog);
  void add_to_group(const mcap::RecordPlace& place);

  Problems& problems_;
  std::vector<ChunkFacts> chunks_;
  bool chunk_is_open_ = false;
  bool has_message_indexes_ = false;
  std::vector<mcap::AttachmentIndex> attachments_;
  std::vector<mcap::MetadataIndex> metadata_;

  std::uint64_t chunk_indexes_ = 0;
  std::uint64_t attachment_indexes_ = 0;
  std::uint64_t metadata_indexes_ = 0;
  std::set<std::uint16_t> repeated_schemas_;
  std::set<std::uint16_t> repeated_channels_;
  std::optional<mcap::Statistics> statistics_;
  std::vector<mcap::SummaryOffset> groups_;   // as they stand
  std::vector<mcap::SummaryOffset> offsets_;  // as the file says
};

}  // namespace roseau::recorder
