#include "recorder/tools/inspect/summary_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace roseau::recorder {

namespace {

bool same_messages(mcap::MessageIndex a, mcap::MessageIndex b) {
  std::ranges::sort(a.entries);
  std::ranges::sort(b.entries);
  return a.entries == b.entries;
}

}  // namespace

// ---------------------------------------------------------------------------------------------------------------------
// The data section

void SummaryCheck::see_chunk(const mcap::RecordPlace& place, const mcap::Chunk& chunk, const mcap::ChunkContent* content) {
  end_chunk();
  ChunkFacts facts;
  facts.expected = {.start_time_ns = chunk.start_time_ns,
                    .end_time_ns = chunk.end_time_ns,
                    .chunk_offset = place.offset,
                    .chunk_length = place.end() - place.offset,
                    .compression = chunk.compression,
                    .compressed_size = chunk.records.size(),
                    .uncompressed_size = chunk.uncompressed_size};
  if (content != nullptr) {
    facts.indexes = content->indexes();
    if (chunk.start_time_ns != content->start_time_ns || chunk.end_time_ns != content->end_time_ns) {
      problems_.add(fmt::format("the chunk at byte {} says log times {} to {}, its messages have {} to {}", place.offset,
                                chunk.start_time_ns, chunk.end_time_ns, content->start_time_ns, content->end_time_ns));
    }
  }
  chunks_.push_back(std::move(facts));
  chunk_is_open_ = true;
}

void SummaryCheck::see_message_index(const mcap::RecordPlace& place, const mcap::MessageIndex& index) {
  const auto where = [&] { return fmt::format("the message index at byte {} (channel {})", place.offset, index.channel_id); };
  has_message_indexes_ = true;
  if (!chunk_is_open_) return problems_.add(where() + " does not stand behind a chunk");
  ChunkFacts& chunk = chunks_.back();
  chunk.expected.message_index_length += place.end() - place.offset;
  if (index.entries.empty()) return;
  if (!chunk.expected.message_index_offsets.emplace(index.channel_id, place.offset).second) {
    return problems_.add(where() + " is the second of its channel behind one chunk");
  }
  if (!chunk.indexes) return;
  const auto content = chunk.indexes->find(index.channel_id);
  if (content == chunk.indexes->end() || !same_messages(content->second, index)) {
    problems_.add(where() + " does not fit what its chunk holds");
  }
}

void SummaryCheck::end_chunk() {
  if (!std::exchange(chunk_is_open_, false)) return;
  ChunkFacts& chunk = chunks_.back();
  const auto& listed = chunk.expected.message_index_offsets;
  if (chunk.indexes && !listed.empty() && listed.size() != chunk.indexes->size()) {
    problems_.add(fmt::format("the chunk at byte {} holds {} channels, {} message indexes follow it",
                              chunk.expected.chunk_offset, chunk.indexes->size(), listed.size()));
  }
  chunk.indexes.reset();  // served its purpose; 16 bytes per message add up
}

void SummaryCheck::see_other(const mcap::RecordPlace& place, const mcap::Record& record) {
  const std::uint64_t length = place.end() - place.offset;
  if (const auto* attachment = std::get_if<mcap::Attachment>(&record)) {
    attachments_.push_back({place.offset, length, attachment->log_time_ns, attachment->create_time_ns, attachment->data.size(),
                            attachment->name, attachment->media_type});
  }
  if (const auto* metadata = std::get_if<mcap::Metadata>(&record)) metadata_.push_back({place.offset, length, metadata->name});
}

// ---------------------------------------------------------------------------------------------------------------------
// The summary

void SummaryCheck::add_to_group(const mcap::RecordPlace& place) {
  const auto opcode = static_cast<mcap::Opcode>(place.opcode);
  if (!groups_.empty() && groups_.back().group == opcode) {
    groups_.back().group_length = place.end() - groups_.back().group_start;
    return;
  }
  if (std::ranges::find(groups_, opcode, &mcap::SummaryOffset::group) != groups_.end()) {
    problems_.add(
        fmt::format("the summary's {} records do not stand together (byte {})", mcap::name_of(place.opcode), place.offset));
  }
  groups_.push_back({opcode, place.offset, place.end() - place.offset});
}

void SummaryCheck::see_summary(const mcap::RecordPlace& place, const mcap::Record& record) {
  if (const auto* offset = std::get_if<mcap::SummaryOffset>(&record)) {
    offsets_.push_back(*offset);
    return;
  }
  add_to_group(place);
  if (const auto* schema = std::get_if<mcap::Schema>(&record)) repeated_schemas_.insert(schema->id);
  if (const auto* channel = std::get_if<mcap::Channel>(&record)) repeated_channels_.insert(channel->id);
  if (const auto* chunk = std::get_if<mcap::ChunkIndex>(&record)) check_chunk_index(*chunk);
  if (const auto* index = std::get_if<mcap::AttachmentIndex>(&record)) {
    ++attachment_indexes_;
    const auto found = std::ranges::lower_bound(attachments_, index->offset, {}, &mcap::AttachmentIndex::offset);
    const bool fits = found != attachments_.end() && found->offset == index->offset && found->length == index->length &&
                      found->name == index->name && found->media_type == index->media_type &&
                      found->data_size == index->data_size && found->log_time_ns == index->log_time_ns &&
                      found->create_time_ns == index->create_time_ns;
    if (!fits)
      problems_.add(
          fmt::format("the index of attachment '{}' does not fit what stands at byte {}", index->name, index->offset));
  }
  if (const auto* index = std::get_if<mcap::MetadataIndex>(&record)) {
    ++metadata_indexes_;
    const auto found = std::ranges::lower_bound(metadata_, index->offset, {}, &mcap::MetadataIndex::offset);
    const bool fits = found != metadata_.end() && found->offset == index->offset && found->length == index->length &&
                      found->name == index->name;
    if (!fits)
      problems_.add(fmt::format("the index of metadata '{}' does not fit what stands at byte {}", index->name, index->offset));
  }
  if (const auto* statistics = std::get_if<mcap::Statistics>(&record)) {
    if (statistics_) problems_.add("the summary holds two statistics records");
    statistics_ = *statistics;
  }
}

void SummaryCheck::check_chunk_index(const mcap::ChunkIndex& index) {
  ++chunk_indexes_;
  const auto found = std::ranges::lower_bound(chunks_, index.chunk_offset, {},
                                              [](const ChunkFacts& chunk) { return chunk.expected.chunk_offset; });
  const auto where = [&] { return fmt::format("the index of the chunk at byte {}", index.chunk_offset); };
  if (found == chunks_.end() || found->expected.chunk_offset != index.chunk_offset) {
    return problems_.add(where() + " points to where no chunk begins");
  }
  if (std::exchange(found->is_indexed, true)) return problems_.add(where() + " is there twice");
  const mcap::ChunkIndex& chunk = found->expected;
  if (index.chunk_length != chunk.chunk_length || index.compression != chunk.compression ||
      index.compressed_size != chunk.compressed_size || index.uncompressed_size != chunk.uncompressed_size) {
    problems_.add(where() + " says other sizes than the chunk");
  }
  if (index.start_time_ns != chunk.start_time_ns || index.end_time_ns != chunk.end_time_ns) {
    problems_.add(where() + " says other times than the chunk");
  }
  if (index.message_index_offsets != chunk.message_index_offsets || index.message_index_length != chunk.message_index_length) {
    problems_.add(where() + " does not fit the message indexes behind the chunk");
  }
}

void SummaryCheck::finish(const mcap::Footer& footer, const StreamCheck& streams, const mcap::Catalog& catalog) {
  end_chunk();
  if (chunk_indexes_ > 0) {
    for (const ChunkFacts& chunk : chunks_) {
      if (!chunk.is_indexed)
        problems_.add(fmt::format("the chunk at byte {} is missing in the index", chunk.expected.chunk_offset));
    }
  }
  const auto compare = [this](const char* what, std::uint64_t indexed, std::uint64_t there) {
    if (indexed > 0 && indexed != there)
      problems_.add(fmt::format("the summary lists {} {}, the file holds {}", indexed, what, there));
  };
  compare("attachments", attachment_indexes_, attachments_.size());
  compare("metadata records", metadata_indexes_, metadata_.size());
  if (statistics_) check_statistics(streams, catalog);
  check_repeated(streams, catalog);
  check_offsets(footer);
}

void SummaryCheck::check_statistics(const StreamCheck& streams, const mcap::Catalog& catalog) {
  const mcap::Statistics& counted = *statistics_;
  const auto compare = [this](const char* what, std::uint64_t says, std::uint64_t there) {
    if (says != there) problems_.add(fmt::format("the summary counts {} {}, the file holds {}", says, what, there));
  };
  compare("messages", counted.message_count, streams.messages());
  compare("schemas", counted.schema_count, catalog.schemas().size());
  compare("channels", counted.channel_count, catalog.channels().size());
  compare("attachments", counted.attachment_count, attachments_.size());
  compare("metadata records", counted.metadata_count, metadata_.size());
  compare("chunks", counted.chunk_count, chunks_.size());
  if (counted.message_start_time_ns != streams.start_time_ns() || counted.message_end_time_ns != streams.end_time_ns()) {
    problems_.add(fmt::format("the summary says log times {} to {}, the messages have {} to {}", counted.message_start_time_ns,
                              counted.message_end_time_ns, streams.start_time_ns(), streams.end_time_ns()));
  }
  if (counted.channel_message_counts.empty()) return;
  auto there = streams.counts();
  for (const auto& [id, count] : counted.channel_message_counts) there.try_emplace(id, 0);
  for (const auto& [id, count] : there) {
    const auto says = counted.channel_message_counts.find(id);
    const std::uint64_t said = says == counted.channel_message_counts.end() ? 0 : says->second;
    if (said == count) continue;
    const mcap::Channel* channel = catalog.channel(id);
    problems_.add(fmt::format("{}: the summary counts {} messages, the file holds {}",
                              channel != nullptr ? channel->topic : fmt::format("channel {}", id), said, count));
  }
}

/// Whoever reads by the index needs every channel that has messages, and its schema, in the summary.
void SummaryCheck::check_repeated(const StreamCheck& streams, const mcap::Catalog& catalog) {
  if (chunk_indexes_ == 0) return;
  for (const auto& [id, count] : streams.counts()) {
    const mcap::Channel* channel = catalog.channel(id);
    if (channel == nullptr) continue;
    const bool has_schema = channel->schema_id == 0 || repeated_schemas_.contains(channel->schema_id);
    if (!repeated_channels_.contains(id) || !has_schema) problems_.add(channel->topic + " is not described in the summary");
  }
}

void SummaryCheck::check_offsets(const mcap::Footer& footer) {
  if (footer.summary_offset_start == 0) {
    if (!offsets_.empty()) problems_.add("the footer does not say where the summary offsets begin");
    return;
  }
  for (const auto& group : groups_) {
    const auto found = std::ranges::find(offsets_, group.group, &mcap::SummaryOffset::group);
    const bool fits =
        found != offsets_.end() && found->group_start == group.group_start && found->group_length == group.group_length;
    if (!fits) {
      problems_.add(fmt::format("the summary offset of the {} records is wrong or missing",
                                mcap::name_of(static_cast<std::uint8_t>(group.group))));
    }
  }
  if (offsets_.size() > groups_.size()) problems_.add("there are summary offsets of groups that the summary does not hold");
}

}  // namespace roseau::recorder
