#include "recorder/format/writer.h"

#include <algorithm>

#include "recorder/format/codec.h"
#include "recorder/format/crc32.h"

namespace roseau::mcap {

namespace {

/// More than any record of the summary has, besides what is of any length in it; of a channel with its entry in the statistics.
constexpr std::uint64_t kIndexBytes = 96;

}  // namespace

Result<void> Writer::append(std::span<const std::byte> bytes) {
  const std::span<const std::byte> parts[] = {bytes};
  if (auto appended = out_.append(parts); !appended) return appended;
  data_crc_ = crc32(data_crc_, bytes);
  position_ += bytes.size();
  return {};
}

template <class T>
Result<void> Writer::write_record(const T& record) {
  scratch_.clear();
  encode(record, scratch_);
  return append(scratch_);
}

Result<void> Writer::begin(const Header& header) {
  ROSEAU_CHECK(position_ == 0);
  scratch_.assign(kMagic.begin(), kMagic.end());
  encode(header, scratch_);
  return append(scratch_);
}

void Writer::remember(const Schema& schema) {
  if (!schema_ids_.insert(schema.id).second) return;
  schemas_.push_back(schema);
  end_bytes_ += kIndexBytes + schema.name.size() + schema.encoding.size() + schema.data.size();
  ++statistics_.schema_count;
}

void Writer::remember(const Channel& channel) {
  if (!channel_ids_.insert(channel.id).second) return;
  channels_.push_back(channel);
  end_bytes_ += kIndexBytes + channel.topic.size() + channel.message_encoding.size();
  for (const auto& [key, value] : channel.metadata) end_bytes_ += 8 + key.size() + value.size();
  ++statistics_.channel_count;
}

void Writer::count_messages(std::uint16_t channel_id, std::uint64_t count, std::uint64_t start_ns, std::uint64_t end_ns) {
  const bool first = statistics_.message_count == 0;
  statistics_.message_start_time_ns = first ? start_ns : std::min(statistics_.message_start_time_ns, start_ns);
  statistics_.message_end_time_ns = first ? end_ns : std::max(statistics_.message_end_time_ns, end_ns);
  statistics_.message_count += count;
  statistics_.channel_message_counts[channel_id] += count;
}

Result<void> Writer::write(const Schema& schema) {
  auto written = write_record(schema);
  if (written) remember(schema);
  return written;
}

Result<void> Writer::write(const Channel& channel) {
  auto written = write_record(channel);
  if (written) remember(channel);
  return written;
}

Result<void> Writer::write(const Message& message) {
  auto written = write_record(message);
  if (written) count_messages(message.channel_id, 1, message.log_time_ns, message.log_time_ns);
  return written;
}

Result<void> Writer::write(const Attachment& attachment) {
  const std::uint64_t offset = position_;
  if (auto written = write_record(attachment); !written) return written;
  ++statistics_.attachment_count;
  attachment_indexes_.push_back({offset, position_ - offset, attachment.log_time_ns, attachment.create_time_ns,
                                 attachment.data.size(), attachment.name, attachment.media_type});
  end_bytes_ += kIndexBytes + attachment.name.size() + attachment.media_type.size();
  return {};
}

Result<void> Writer::write(const Metadata& metadata) {
  const std::uint64_t offset = position_;
  if (auto written = write_record(metadata); !written) return written;
  ++statistics_.metadata_count;
  metadata_indexes_.push_back({offset, position_ - offset, metadata.name});
  end_bytes_ += kIndexBytes + metadata.name.size();
  return {};
}

Result<void> Writer::write_private(Opcode opcode, const Metadata& content) {
  ROSEAU_CHECK(opcode >= Opcode::first_private);
  scratch_.clear();
  encode_private(opcode, content, scratch_);
  return append(scratch_);
}

Result<void> Writer::write(const OtherRecord& record) { return write_record(record); }

Result<void> Writer::write(const ChunkBuilder& chunk) {
  if (chunk.empty()) return {};
  auto stored = store(chunk);
  if (!stored) return stored.error();
  if (auto appended = append_chunk(*stored, chunk.indexes()); !appended) return appended;
  count(*stored, chunk.schemas(), chunk.channels(), chunk.indexes());
  return {};
}

Result<void> Writer::copy(const Chunk& chunk, std::uint32_t stored_crc, const ChunkContent& content) {
  StoredChunk stored{.record = chunk, .bytes = chunk.records.size(), .crc = stored_crc};
  stored.record.start_time_ns = content.start_time_ns;
  stored.record.end_time_ns = content.end_time_ns;
  parts_.assign(1, chunk.records);
  const auto indexes = content.indexes();
  if (auto appended = append_chunk(stored, indexes); !appended) return appended;
  count(stored, content.schemas, content.channels, indexes);
  return {};
}

/// parts_ holds the stored records.
Result<void> Writer::append_chunk(const StoredChunk& stored, const std::map<std::uint16_t, MessageIndex>& indexes) {
  const Chunk& record = stored.record;
  scratch_.clear();
  encode_chunk_head(record, stored.bytes, scratch_);
  ChunkIndex index{.start_time_ns = record.start_time_ns,
                   .end_time_ns = record.end_time_ns,
                   .chunk_offset = position_,
                   .chunk_length = scratch_.size() + stored.bytes,
                   .compression = record.compression,
                   .compressed_size = stored.bytes,
                   .uncompressed_size = record.uncompressed_size};
  const auto message_indexes = encode_message_indexes(indexes, position_ + index.chunk_length, index);

  parts_.insert(parts_.begin(), scratch_);
  parts_.push_back(message_indexes);
  if (auto appended = out_.append(parts_); !appended) return appended;
  data_crc_ = crc32(data_crc_, scratch_);
  data_crc_ = crc32_combine(data_crc_, stored.crc, stored.bytes);
  data_crc_ = crc32(data_crc_, message_indexes);
  position_ += index.chunk_length + message_indexes.size();
  end_bytes_ += kIndexBytes + 10 * index.message_index_offsets.size();
  chunk_indexes_.push_back(std::move(index));
  out_.keep_back(end_bytes_);
  return {};
}

/// Compresses the chunk where that is wanted and helps; what is to be written is then in parts_. The records are summed once:
/// for the chunk's own CRC and, stored as they are, for the data section's.
Result<Writer::StoredChunk> Writer::store(const ChunkBuilder& chunk) {
  parts_.clear();
  chunk.parts(parts_);
  StoredChunk stored{.record = {.start_time_ns = chunk.start_time_ns(),
                                .end_time_ns = chunk.end_time_ns(),
                                .uncompressed_size = chunk.uncompressed_bytes()},
                     .bytes = chunk.uncompressed_bytes()};
  for (const auto& part : parts_) stored.crc = crc32(stored.crc, part);
  stored.record.uncompressed_crc = stored.crc;
  if (chunk.compression() == Compression::none) return stored;

  ROSEAU_CHECK(parts_.size() == 1);
  if (auto done = compress(chunk.compression(), parts_[0], compressed_); !done) return done.error();
  if (compressed_.size() >= chunk.uncompressed_bytes()) return stored;
  parts_[0] = compressed_;
  stored.record.compression = to_string(chunk.compression());
  stored.bytes = compressed_.size();
  stored.crc = crc32(0, compressed_);
  return stored;
}

void Writer::count(const StoredChunk& stored, const std::vector<Schema>& schemas, const std::vector<Channel>& channels,
                   const std::map<std::uint16_t, MessageIndex>& indexes) {
  ++statistics_.chunk_count;
  for (const Schema& schema : schemas) remember(schema);
  for (const Channel& channel : channels) remember(channel);
  for (const auto& [channel_id, messages] : indexes) {
    if (messages.entries.empty()) continue;
    count_messages(channel_id, messages.entries.size(), stored.record.start_time_ns, stored.record.end_time_ns);
  }
}

std::vector<std::byte> Writer::encode_message_indexes(const std::map<std::uint16_t, MessageIndex>& indexes,
                                                      std::uint64_t position, ChunkIndex& index) const {
  std::vector<std::byte> bytes;
  if (!options_.message_indexes) return bytes;
  for (const auto& [channel_id, messages] : indexes) {
    if (messages.entries.empty()) continue;
    index.message_index_offsets[channel_id] = position + bytes.size();
    encode(messages, bytes);
  }
  index.message_index_length = bytes.size();
  return bytes;
}

template <class T>
void Writer::add_group(Opcode opcode, const std::vector<T>& records, bool wanted, std::vector<std::byte>& summary,
                       std::vector<SummaryOffset>& offsets) const {
  if (!wanted || records.empty()) return;
  const std::size_t begin = summary.size();
  for (const T& record : records) encode(record, summary);
  offsets.push_back({opcode, position_ + begin, summary.size() - begin});
}

Result<void> Writer::finish() {
  if (auto written = write_record(DataEnd{data_crc_}); !written) return written;

  std::vector<std::byte> summary;
  std::vector<SummaryOffset> offsets;
  add_group(Opcode::schema, schemas_, options_.repeat_schemas, summary, offsets);
  add_group(Opcode::channel, channels_, options_.repeat_channels, summary, offsets);
  add_group(Opcode::statistics, std::vector{statistics_}, options_.statistics, summary, offsets);
  add_group(Opcode::metadata_index, metadata_indexes_, options_.metadata_indexes, summary, offsets);
  add_group(Opcode::attachment_index, attachment_indexes_, options_.attachment_indexes, summary, offsets);
  add_group(Opcode::chunk_index, chunk_indexes_, options_.chunk_indexes, summary, offsets);

  Footer footer;
  if (!summary.empty()) {
    footer.summary_start = position_;
    if (options_.summary_offsets) {
      footer.summary_offset_start = position_ + summary.size();
      for (const SummaryOffset& offset : offsets) encode(offset, summary);
    }
  }
  footer.summary_crc = crc32(crc32(0, summary), footer_prefix(footer));
  encode(footer, summary);
  summary.insert(summary.end(), kMagic.begin(), kMagic.end());
  return append(summary);
}

}  // namespace roseau::mcap
