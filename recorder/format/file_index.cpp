#include "recorder/format/file_index.h"

#include <algorithm>
#include <array>
#include <map>

#include "recorder/format/codec.h"
#include "recorder/format/crc32.h"
#include "recorder/format/record_reader.h"
#include "recorder/format/stream_reader.h"

namespace roseau::mcap {

namespace {

constexpr std::uint64_t kFooterBytes = kRecordHeadBytes + 20;
constexpr std::uint64_t kMaxRunBytes = 4U << 20U;  // of messages outside of chunks, read at once

void sort_blocks(FileIndex& index) {
  std::ranges::sort(index.blocks, {}, [](const MessageBlock& block) { return std::pair(block.start_time_ns, block.offset); });
}

Error summary_error(const std::string& what) { return {ErrorCode::corrupt, what}; }

// ---------------------------------------------------------------------------------------------------------------------
// From the summary

Result<Footer> read_footer(Readable& in) {
  if (in.size() < kMagic.size() + kFooterBytes + kMagic.size()) return summary_error("is too short for a footer");
  std::array<std::byte, kFooterBytes + kMagic.size()> end{};
  if (auto read = in.read(in.size() - end.size(), end); !read) return read.error();
  const std::span<const std::byte> bytes(end);
  const RecordHead head = decode_head(bytes);
  if (!std::ranges::equal(bytes.subspan(kFooterBytes), kMagic) || head.opcode != static_cast<std::uint8_t>(Opcode::footer) ||
      head.content_bytes != kFooterBytes - kRecordHeadBytes) {
    return summary_error("does not end with a footer: it was cut off");
  }
  auto record = decode(head.opcode, bytes.subspan(kRecordHeadBytes, head.content_bytes));
  if (!record) return record.error();
  return std::get<Footer>(*record);
}

Result<Header> read_header(Readable& in) {
  RecordReader records(in, kMagic.size(), in.size());
  const auto place = records.next();
  if (!place) return place.error();
  if (!*place || (*place)->opcode != static_cast<std::uint8_t>(Opcode::header)) {
    return summary_error("does not begin with a header record");
  }
  auto record = records.decode(**place);
  if (!record) return record.error();
  return std::get<Header>(*record);
}

Result<void> check_summary_crc(Readable& in, const Footer& footer, std::uint64_t summary_end) {
  if (footer.summary_crc == 0) return {};
  RecordReader bytes(in, footer.summary_start, summary_end);
  const auto summary = bytes.bytes(footer.summary_start, summary_end - footer.summary_start);
  if (!summary) return summary.error();
  if (crc32(crc32(0, *summary), footer_prefix(footer)) != footer.summary_crc) {
    return summary_error("the summary's CRC does not match");
  }
  return {};
}

MessageBlock block_of(const ChunkIndex& chunk) {
  MessageBlock block{.offset = chunk.chunk_offset,
                     .length = chunk.chunk_length,
                     .start_time_ns = chunk.start_time_ns,
                     .end_time_ns = chunk.end_time_ns};
  if (!chunk.message_index_offsets.empty()) {
    block.channels.emplace();
    for (const auto& [channel_id, offset] : chunk.message_index_offsets) block.channels->push_back(channel_id);
  }
  return block;
}

/// How many messages the chunk's indexes list, told by their length alone.
std::uint64_t indexed_messages(const ChunkIndex& chunk) {
  constexpr std::uint64_t kIndexHead = kRecordHeadBytes + 2 + 4;
  constexpr std::uint64_t kEntry = 16;
  const std::uint64_t heads = chunk.message_index_offsets.size() * kIndexHead;
  return chunk.message_index_length < heads ? 0 : (chunk.message_index_length - heads) / kEntry;
}

struct SummaryCounts {
  bool has_statistics = false;
  std::uint64_t indexed_messages = 0;
};

Result<void> add_summary_record(const Record& record, FileIndex& index, SummaryCounts& counts) {
  if (const auto* schema = std::get_if<Schema>(&record)) return index.catalog.add(*schema);
  if (const auto* channel = std::get_if<Channel>(&record)) return index.catalog.add(*channel);
  if (const auto* chunk = std::get_if<ChunkIndex>(&record)) {
    index.blocks.push_back(block_of(*chunk));
    counts.indexed_messages += indexed_messages(*chunk);
  }
  if (const auto* attachment = std::get_if<AttachmentIndex>(&record)) index.attachments.push_back(*attachment);
  if (const auto* metadata = std::get_if<MetadataIndex>(&record)) index.metadata.push_back(*metadata);
  if (const auto* statistics = std::get_if<Statistics>(&record)) {
    index.statistics = *statistics;
    counts.has_statistics = true;
  }
  return {};
}

/// Every place that the summary names lies in the data section, and everything that was counted is there: messages outside of
/// chunks, for one, are in no index.
bool summary_says_everything(const FileIndex& index, const SummaryCounts& counts, std::uint64_t summary_start) {
  const auto inside = [&](std::uint64_t offset, std::uint64_t length) {
    return offset >= kMagic.size() && offset <= summary_start && length >= kRecordHeadBytes && length <= summary_start - offset;
  };
  const Statistics& counted = index.statistics;
  return std::ranges::all_of(index.blocks, [&](const auto& block) { return inside(block.offset, block.length); }) &&
         std::ranges::all_of(index.attachments, [&](const auto& entry) { return inside(entry.offset, entry.length); }) &&
         std::ranges::all_of(index.metadata, [&](const auto& entry) { return inside(entry.offset, entry.length); }) &&
         counted.chunk_count == index.blocks.size() && counted.attachment_count == index.attachments.size() &&
         counted.metadata_count == index.metadata.size() && counted.channel_count == index.catalog.channels().size() &&
         counted.schema_count == index.catalog.schemas().size() && counts.has_statistics &&
         counted.message_count == counts.indexed_messages;
}

/// Nothing when the file is whole but its summary does not hold enough to do without the rest.
Result<std::optional<FileIndex>> index_from_summary(Readable& in, const Footer& footer) {
  if (footer.summary_start == 0) return std::optional<FileIndex>{};
  const std::uint64_t footer_offset = in.size() - kMagic.size() - kFooterBytes;
  const std::uint64_t summary_end = footer.summary_offset_start == 0 ? footer_offset : footer.summary_offset_start;
  if (footer.summary_start < kMagic.size() || footer.summary_start > summary_end || summary_end > footer_offset) {
    return summary_error("the footer points outside of the file");
  }
  if (auto checked = check_summary_crc(in, footer, footer_offset); !checked) return checked.error();
  auto header = read_header(in);
  if (!header) return header.error();
  FileIndex index{.header = std::move(*header)};
  SummaryCounts counts;
  RecordReader records(in, footer.summary_start, summary_end);
  while (true) {
    const auto place = records.next();
    if (!place) return place.error();
    if (!*place) break;
    const auto record = records.decode(**place);
    if (!record) return record.error();
    // A channel without its schema, for one: legal, but then the rest of the file must be looked at.
    if (auto added = add_summary_record(*record, index, counts); !added) return std::optional<FileIndex>{};
  }
  if (!summary_says_everything(index, counts, footer.summary_start)) return std::optional<FileIndex>{};
  return std::optional(std::move(index));
}

// ---------------------------------------------------------------------------------------------------------------------
// By walking over the file

class Walk {
 public:
  Walk(Readable& in, const ReaderOptions& options)
      : options_(options), records_(in, kMagic.size(), in.size(), options.max_record_bytes) {}

  Result<FileIndex> run() {
    while (true) {
      const auto place = records_.next();
      if (!place) {
        if (place.error().code == ErrorCode::io) return place.error();
        damaged(place.error().message);
        break;
      }
      if (!*place) {
        damaged("ends without a footer");
        break;
      }
      const auto opcode = static_cast<Opcode>((*place)->opcode);
      if (opcode == Opcode::data_end || opcode == Opcode::footer) break;
      if (auto seen = see(**place, opcode); !seen) {
        if (seen.error().code == ErrorCode::io) return seen.error();
        damaged("at byte " + std::to_string((*place)->offset) + ": " + seen.error().message);
      }
    }
    end_run();
    end_chunk();
    finish();
    return std::move(index_);
  }

 private:
  void damaged(const std::string& what) {
    index_.complete = false;
    index_.damage.push_back(what);
    cut_ = true;
  }

  Result<void> see(const RecordPlace& place, Opcode opcode) {
    if (opcode == Opcode::message_index) return see_message_index(place);
    end_chunk();
    if (opcode == Opcode::message) return see_message(place);
    if (opcode != Opcode::schema && opcode != Opcode::channel) end_run();
    if (opcode >= Opcode::first_private) {
      index_.private_records.push_back({place.opcode, place.offset, place.content_bytes});
      return {};
    }
    if (opcode == Opcode::chunk) return see_chunk(place);
    if (opcode == Opcode::attachment) return see_attachment(place);
    const auto record = records_.decode(place);
    if (!record) return record.error();
    if (const auto* schema = std::get_if<Schema>(&*record)) return define(*schema);
    if (const auto* channel = std::get_if<Channel>(&*record)) return define(*channel);
    if (const auto* header = std::get_if<Header>(&*record)) index_.header = *header;
    if (const auto* metadata = std::get_if<Metadata>(&*record)) {
      index_.metadata.push_back({place.offset, place.end() - place.offset, metadata->name});
    }
    return {};
  }

  /// A run of messages ends where a definition is refused: it would cost the messages on both sides.
  template <class T>
  Result<void> define(const T& definition) {
    auto added = index_.catalog.add(definition);
    if (!added) end_run();
    return added;
  }

  Result<void> see_attachment(const RecordPlace& place) {
    const auto record = records_.decode(place);
    if (!record) return record.error();
    const auto& attachment = std::get<Attachment>(*record);
    index_.attachments.push_back({place.offset, place.end() - place.offset, attachment.log_time_ns, attachment.create_time_ns,
                                  attachment.data.size(), attachment.name, attachment.media_type});
    return {};
  }

  /// Only the chunk's own head: what it holds is learnt from the message indexes behind it, or else in end_chunk.
  Result<void> see_chunk(const RecordPlace& place) {
    const auto head = records_.bytes(place.content_offset(), std::min<std::uint64_t>(place.content_bytes, 16));
    if (!head) return head.error();
    if (head->size() < 16) return Error{ErrorCode::corrupt, "the chunk is too short"};
    MessageBlock block{.offset = place.offset, .length = place.end() - place.offset};
    std::ranges::copy(head->first(8), std::as_writable_bytes(std::span(&block.start_time_ns, 1)).begin());
    std::ranges::copy(head->subspan(8), std::as_writable_bytes(std::span(&block.end_time_ns, 1)).begin());
    ++index_.statistics.chunk_count;
    open_chunk_ = block;
    open_chunk_counts_.clear();
    return {};
  }

  Result<void> see_message_index(const RecordPlace& place) {
    const auto record = records_.decode(place);
    if (!record) return record.error();
    const auto& entries = std::get<MessageIndex>(*record);
    if (open_chunk_) open_chunk_counts_[entries.channel_id] += entries.entries.size();
    return {};
  }

  /// The indexes behind a chunk are believed when they are there and all their channels are known. Not behind the last chunk of
  /// a cut file: some of them may be missing.
  void end_chunk() {
    if (!open_chunk_) return;
    MessageBlock block = *std::exchange(open_chunk_, std::nullopt);
    const bool known = std::ranges::all_of(open_chunk_counts_, [&](const auto& channel_and_count) {
      return index_.catalog.channel(channel_and_count.first) != nullptr;
    });
    if (open_chunk_counts_.empty() || !known || cut_) {
      if (auto read = read_chunk(block); !read) {
        return damaged("the chunk at byte " + std::to_string(block.offset) + " is lost: " + read.error().message);
      }
    }
    block.channels.emplace();
    for (const auto& [channel_id, count] : open_chunk_counts_) {
      block.channels->push_back(channel_id);
      index_.statistics.channel_message_counts[channel_id] += count;
    }
    if (!open_chunk_counts_.empty()) index_.blocks.push_back(std::move(block));
  }

  /// Learns schemas, channels, counts and times from the chunk itself.
  Result<void> read_chunk(MessageBlock& block) {
    open_chunk_counts_.clear();
    const auto content = records_.bytes(block.offset + kRecordHeadBytes, block.length - kRecordHeadBytes);
    if (!content) return content.error();
    const auto record = decode(static_cast<std::uint8_t>(Opcode::chunk), *content);
    if (!record) return record.error();
    const auto records = chunk_records(std::get<Chunk>(*record), buffer_, options_);
    if (!records) return records.error();
    std::uint64_t position = 0;
    bool first = true;
    while (true) {
      const auto place = next_record(*records, position);
      if (!place) return place.error();
      if (!*place) return {};
      const auto inner = decode((*place)->opcode, records->subspan((*place)->content_offset(), (*place)->content_bytes));
      if (!inner) return inner.error();
      Result<void> added;
      if (const auto* schema = std::get_if<Schema>(&*inner)) added = index_.catalog.add(*schema);
      if (const auto* channel = std::get_if<Channel>(&*inner)) added = index_.catalog.add(*channel);
      if (!added) return added;
      if (const auto* message = std::get_if<Message>(&*inner)) {
        ++open_chunk_counts_[message->channel_id];
        block.start_time_ns = first ? message->log_time_ns : std::min(block.start_time_ns, message->log_time_ns);
        block.end_time_ns = first ? message->log_time_ns : std::max(block.end_time_ns, message->log_time_ns);
        first = false;
      }
    }
  }

  Result<void> see_message(const RecordPlace& place) {
    if (place.content_bytes < kMessageHeadBytes - kRecordHeadBytes) {
      return Error{ErrorCode::corrupt, "the message is too short"};
    }
    const auto head = records_.bytes(place.content_offset(), kMessageHeadBytes - kRecordHeadBytes);
    if (!head) return head.error();
    const auto record = decode(place.opcode, *head);
    if (!record) return record.error();
    const auto& message = std::get<Message>(*record);
    if (run_ && place.end() - run_->offset > kMaxRunBytes) end_run();
    if (!run_) {
      run_ = MessageBlock{
          .offset = place.offset, .start_time_ns = message.log_time_ns, .end_time_ns = message.log_time_ns, .is_chunk = false};
    }
    run_->length = place.end() - run_->offset;
    run_->start_time_ns = std::min(run_->start_time_ns, message.log_time_ns);
    run_->end_time_ns = std::max(run_->end_time_ns, message.log_time_ns);
    ++index_.statistics.channel_message_counts[message.channel_id];
    return {};
  }

  void end_run() {
    if (run_) index_.blocks.push_back(*std::exchange(run_, std::nullopt));
  }

  void finish() {
    Statistics& statistics = index_.statistics;
    for (const auto& [channel_id, count] : statistics.channel_message_counts) statistics.message_count += count;
    statistics.schema_count = static_cast<std::uint16_t>(index_.catalog.schemas().size());
    statistics.channel_count = static_cast<std::uint32_t>(index_.catalog.channels().size());
    statistics.attachment_count = static_cast<std::uint32_t>(index_.attachments.size());
    statistics.metadata_count = static_cast<std::uint32_t>(index_.metadata.size());
    if (index_.blocks.empty()) return;
    statistics.message_start_time_ns = std::ranges::min(index_.blocks, {}, &MessageBlock::start_time_ns).start_time_ns;
    statistics.message_end_time_ns = std::ranges::max(index_.blocks, {}, &MessageBlock::end_time_ns).end_time_ns;
  }

  const ReaderOptions& options_;
  RecordReader records_;
  FileIndex index_;
  bool cut_ = false;
  std::optional<MessageBlock> open_chunk_;  // its message indexes may still follow
  std::map<std::uint16_t, std::uint64_t> open_chunk_counts_;
  std::optional<MessageBlock> run_;
  std::vector<std::byte> buffer_;
};

}  // namespace

Result<void> check_ending(Readable& in) {
  if (auto magic = check_opening_magic(in); !magic) return magic;
  const auto footer = read_footer(in);
  if (!footer) return footer.error();
  if (footer->summary_start == 0) return {};
  const std::uint64_t footer_offset = in.size() - kMagic.size() - kFooterBytes;
  if (footer->summary_start > footer_offset) return summary_error("the footer points outside of the file");
  return check_summary_crc(in, *footer, footer_offset);
}

Result<FileIndex> read_file_index(Readable& in, const ReaderOptions& options) {
  if (auto magic = check_opening_magic(in); !magic) return magic.error();
  const auto footer = read_footer(in);
  std::optional<Error> summary_fault;
  if (footer) {
    auto index = index_from_summary(in, *footer);
    if (index && *index) {
      sort_blocks(**index);
      return std::move(**index);
    }
    if (!index) summary_fault = index.error();
  } else {
    summary_fault = footer.error();
  }
  if (summary_fault && summary_fault->code == ErrorCode::io) return *summary_fault;

  auto index = Walk(in, options).run();
  if (!index) return index;
  // A file that was cut off has no footer: the walk has said where it ends, unless the cut went through the summary.
  if (summary_fault && (footer || index->damage.empty())) {
    index->complete = false;
    index->damage.insert(index->damage.begin(), summary_fault->message);
  }
  sort_blocks(*index);
  return index;
}

}  // namespace roseau::mcap
