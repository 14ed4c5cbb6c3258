#include "recorder/format/indexed_reader.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "recorder/format/codec.h"
#include "recorder/format/file_io.h"
#include "recorder/format/record_reader.h"

namespace roseau::mcap {

Result<std::unique_ptr<IndexedReader>> IndexedReader::open(const std::filesystem::path& path, ReaderOptions options) {
  auto file = FileReadable::open(path);
  if (!file) return file.error();
  auto reader = open(std::unique_ptr<Readable>(std::move(*file)), options);
  if (!reader) return Error{reader.error().code, path.string() + " " + reader.error().message};
  return reader;
}

Result<std::unique_ptr<IndexedReader>> IndexedReader::open(std::unique_ptr<Readable> in, ReaderOptions options) {
  std::unique_ptr<IndexedReader> reader(new IndexedReader(std::move(in), options));
  auto index = read_file_index(*reader->in_, options);
  if (!index) return index.error();
  reader->index_ = std::move(*index);
  return reader;
}

const Channel* IndexedReader::channel_of_topic(std::string_view topic) const {
  for (const auto& [id, channel] : catalog().channels()) {
    if (channel.topic == topic) return &channel;
  }
  return nullptr;
}

Result<std::vector<std::byte>> IndexedReader::read_content(std::uint64_t offset, std::uint64_t length, Opcode expected) {
  RecordReader records(*in_, offset, offset + length);
  const auto place = records.next();
  if (!place) return place.error();
  if (!*place || (*place)->opcode != static_cast<std::uint8_t>(expected)) {
    return Error{ErrorCode::corrupt, "no " + name_of(static_cast<std::uint8_t>(expected)) + " record at byte " +
                                         std::to_string(offset) + ", where the index says"};
  }
  const auto content = records.content(**place);
  if (!content) return content.error();
  return std::vector(content->begin(), content->end());
}

Result<Attachment> IndexedReader::read(const AttachmentIndex& index, std::vector<std::byte>& buffer) {
  auto content = read_content(index.offset, index.length, Opcode::attachment);
  if (!content) return content.error();
  buffer = std::move(*content);
  auto record = decode(static_cast<std::uint8_t>(Opcode::attachment), buffer);
  if (!record) return record.error();
  auto attachment = std::get<Attachment>(std::move(*record));
  if (auto checked = check_attachment_crc(attachment, buffer); !checked) return checked.error();
  return attachment;
}

Result<Metadata> IndexedReader::read(const MetadataIndex& index) {
  const auto content = read_content(index.offset, index.length, Opcode::metadata);
  if (!content) return content.error();
  return decode_metadata(*content);
}

Result<Metadata> IndexedReader::read(const PrivateRecord& record) {
  const auto content = read_content(record.offset, kRecordHeadBytes + record.content_bytes, static_cast<Opcode>(record.opcode));
  if (!content) return content.error();
  return decode_metadata(*content);
}

Result<std::optional<Metadata>> IndexedReader::find_metadata(std::string_view name) {
  const auto found = std::ranges::find(index_.metadata, name, &MetadataIndex::name);
  if (found == index_.metadata.end()) return std::optional<Metadata>{};
  auto metadata = read(*found);
  if (!metadata) return metadata.error();
  return std::optional(std::move(*metadata));
}

// ---------------------------------------------------------------------------------------------------------------------
// MessageCursor: a merge of the blocks that are open at one time

namespace {

struct OpenBlock {
  struct Entry {
    std::uint64_t log_time_ns;
    std::uint64_t offset;  // of the message record in `records`
  };
  std::uint64_t block_offset = 0;  // in the file: ties of log time keep the file's order
  std::vector<std::byte> stored;   // as in the file
  std::vector<std::byte> decompressed;
  std::span<const std::byte> records;
  std::vector<Entry> entries;  // wanted messages, in order of log time
  std::size_t next = 0;

  std::uint64_t held_bytes() const { return stored.size() + decompressed.size(); }
  auto key() const { return std::tuple(entries[next].log_time_ns, block_offset, entries[next].offset); }
};

/// For std heap algorithms, which keep the greatest in front.
bool later(const std::unique_ptr<OpenBlock>& a, const std::unique_ptr<OpenBlock>& b) { return a->key() > b->key(); }

}  // namespace

struct MessageCursor::State {
  IndexedReader& reader;
  MessageQuery query;
  std::size_t next_block = 0;                    // of reader.index().blocks, that are sorted by start time
  std::vector<std::unique_ptr<OpenBlock>> open;  // heap by key()
  std::unique_ptr<OpenBlock> spent;              // holds the bytes of the message handed out last
  std::vector<std::unique_ptr<OpenBlock>> free;  // their memory is used again
  std::uint64_t open_bytes = 0;                  // in `open` and `spent`

  bool wanted(const MessageBlock& block) const;
  bool wants_channel(std::uint16_t id) const {
    return !query.channels || std::ranges::find(*query.channels, id) != query.channels->end();
  }
  Result<void> open_due_blocks();
  Result<void> open_block(const MessageBlock& block);
  Result<void> check_room(std::uint64_t bytes) const;
  Result<void> load(const MessageBlock& block, OpenBlock& into);
  Result<void> collect(OpenBlock& block);
  void recycle(std::unique_ptr<OpenBlock> block);
};

MessageCursor::MessageCursor(std::unique_ptr<State> state) : state_(std::move(state)) {}
MessageCursor::MessageCursor(MessageCursor&&) noexcept = default;
MessageCursor& MessageCursor::operator=(MessageCursor&&) noexcept = default;
MessageCursor::~MessageCursor() = default;

MessageCursor IndexedReader::messages(MessageQuery query) {
  return MessageCursor(std::make_unique<MessageCursor::State>(*this, std::move(query)));
}

bool MessageCursor::State::wanted(const MessageBlock& block) const {
  if (block.end_time_ns < query.start_time_ns || block.start_time_ns > query.end_time_ns) return false;
  return !block.channels || std::ranges::any_of(*block.channels, [this](std::uint16_t id) { return wants_channel(id); });
}

Result<std::optional<ReadMessage>> MessageCursor::next() {
  State& state = *state_;
  if (state.spent) state.recycle(std::move(state.spent));
  if (auto opened = state.open_due_blocks(); !opened) return opened.error();
  if (state.open.empty()) return std::optional<ReadMessage>{};

  std::ranges::pop_heap(state.open, later);
  OpenBlock& block = *state.open.back();
  std::uint64_t position = block.entries[block.next].offset;
  const auto place = next_record(block.records, position);
  ROSEAU_CHECK(place && *place);
  const auto content = block.records.subspan((*place)->content_offset(), (*place)->content_bytes);
  const auto record = decode((*place)->opcode, content);
  ROSEAU_CHECK(record);
  const Message message = std::get<Message>(*record);

  if (++block.next < block.entries.size()) {
    std::ranges::push_heap(state.open, later);
  } else {
    state.spent = std::move(state.open.back());
    state.open.pop_back();
  }
  return std::optional(ReadMessage{state.reader.catalog().channel(message.channel_id), message});
}

/// Every block that may hold a message earlier than the earliest at hand.
Result<void> MessageCursor::State::open_due_blocks() {
  const auto& blocks = reader.index().blocks;
  while (next_block < blocks.size()) {
    const MessageBlock& block = blocks[next_block];
    if (!open.empty() && block.start_time_ns > open.front()->entries[open.front()->next].log_time_ns) return {};
    ++next_block;
    if (!wanted(block)) continue;
    if (auto opened = open_block(block); !opened) {
      return opened.error().with_context("at byte " + std::to_string(block.offset));
    }
  }
  return {};
}

Result<void> MessageCursor::State::open_block(const MessageBlock& block) {
  std::unique_ptr<OpenBlock> opened;
  if (free.empty()) {
    opened = std::make_unique<OpenBlock>();
  } else {
    opened = std::move(free.back());
    free.pop_back();
  }
  opened->block_offset = block.offset;
  opened->next = 0;
  opened->entries.clear();
  opened->stored.clear();
  opened->decompressed.clear();
  auto loaded = load(block, *opened);
  if (loaded) loaded = collect(*opened);
  open_bytes += opened->held_bytes();
  if (!loaded || opened->entries.empty()) {
    recycle(std::move(opened));
    return loaded;
  }
  open.push_back(std::move(opened));
  std::ranges::push_heap(open, later);
  return {};
}

/// Whether a block of this size may be opened beside those that are open.
Result<void> MessageCursor::State::check_room(std::uint64_t bytes) const {
  const ReaderOptions& options = reader.options_;
  if (bytes <= options.max_open_bytes && open_bytes <= options.max_open_bytes - bytes) return {};
  return Error{ErrorCode::unsupported, "too many chunks overlap in time here, or this one is too large"};
}

Result<void> MessageCursor::State::load(const MessageBlock& block, OpenBlock& into) {
  if (block.length > reader.in_->size() || block.offset > reader.in_->size() - block.length) {
    return Error{ErrorCode::corrupt, "the index points outside of the file"};
  }
  if (auto fits = check_room(block.length); !fits) return fits;
  if (block.length > into.stored.capacity()) std::vector<std::byte>().swap(into.stored);
  into.stored.resize(block.length);
  if (auto read = reader.in_->read(block.offset, into.stored); !read) return read;
  into.records = into.stored;
  if (!block.is_chunk) return {};

  std::uint64_t position = 0;
  const auto place = next_record(into.stored, position);
  if (!place) return place.error();
  if (!*place || (*place)->opcode != static_cast<std::uint8_t>(Opcode::chunk)) {
    return Error{ErrorCode::corrupt, "there is no chunk where the index says"};
  }
  const auto record = decode((*place)->opcode, std::span(into.stored).subspan(kRecordHeadBytes, (*place)->content_bytes));
  if (!record) return record.error();
  const auto& chunk = std::get<Chunk>(*record);
  if (auto fits = check_room(block.length + (chunk.compression.empty() ? 0 : chunk.uncompressed_size)); !fits) return fits;
  const auto records = chunk_records(chunk, into.decompressed, reader.options_);
  if (!records) return records.error();
  into.records = *records;
  return {};
}

/// Finds the wanted messages. The records tell more surely than the message indexes, and cost hardly more.
Result<void> MessageCursor::State::collect(OpenBlock& block) {
  std::uint64_t position = 0;
  while (true) {
    const auto place = next_record(block.records, position);
    if (!place) return place.error().with_context("the chunk");
    if (!*place) break;
    const auto opcode = static_cast<Opcode>((*place)->opcode);
    if (opcode != Opcode::message && opcode != Opcode::schema && opcode != Opcode::channel) continue;
    const auto record = decode((*place)->opcode, block.records.subspan((*place)->content_offset(), (*place)->content_bytes));
    if (!record) return record.error();
    Result<void> added;
    if (const auto* schema = std::get_if<Schema>(&*record)) added = reader.index_.catalog.add(*schema);
    if (const auto* channel = std::get_if<Channel>(&*record)) added = reader.index_.catalog.add(*channel);
    if (!added) return added;
    const auto* message = std::get_if<Message>(&*record);
    if (message == nullptr || !wants_channel(message->channel_id)) continue;
    if (reader.catalog().channel(message->channel_id) == nullptr) {
      return Error{ErrorCode::corrupt,
                   "a message of channel " + std::to_string(message->channel_id) + ", which is not described"};
    }
    if (message->log_time_ns < query.start_time_ns || message->log_time_ns > query.end_time_ns) continue;
    block.entries.push_back({message->log_time_ns, (*place)->offset});
  }
  std::ranges::stable_sort(block.entries, {}, &OpenBlock::Entry::log_time_ns);
  return {};
}

void MessageCursor::State::recycle(std::unique_ptr<OpenBlock> block) {
  constexpr std::size_t kMostKept = 8;
  constexpr std::uint64_t kMostKeptBytes = 32U << 20U;  // each
  open_bytes -= block->held_bytes();
  if (free.size() < kMostKept && block->stored.capacity() + block->decompressed.capacity() <= kMostKeptBytes)
    free.push_back(std::move(block));
}

}  // namespace roseau::mcap
