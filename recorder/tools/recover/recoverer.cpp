#include "recorder/tools/recover/recoverer.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "recorder/format/crc32.h"
#include "recorder/format/file_index.h"
#include "recorder/format/stream_reader.h"

namespace roseau::recorder {

namespace {

using mcap::Opcode;
using mcap::RecordPlace;

constexpr std::uint64_t kProgressStep = 1U << 20U;
constexpr std::uint64_t kLooseChunkBytes = 4U << 20U;
constexpr std::string_view kRecoveredMetadata = "roseau.recovered";

std::uint8_t code(Opcode opcode) { return static_cast<std::uint8_t>(opcode); }

mcap::Message message_at(std::span<const std::byte> records, std::uint64_t offset) {
  std::uint64_t position = offset;
  const auto place = mcap::next_record(records, position);
  ROSEAU_CHECK(place && *place);
  const auto record = mcap::decode((*place)->opcode, records.subspan((*place)->content_offset(), (*place)->content_bytes));
  ROSEAU_CHECK(record);
  return std::get<mcap::Message>(*record);
}

std::array<std::byte, mcap::kRecordHeadBytes> head_bytes(const RecordPlace& place) {
  std::array<std::byte, mcap::kRecordHeadBytes> head{};
  head[0] = static_cast<std::byte>(place.opcode);
  for (std::size_t i = 0; i < 8; ++i) head[1 + i] = static_cast<std::byte>(place.content_bytes >> (8 * i));
  return head;
}

/// The times in a chunk's head, when they make sense.
void take_times(const mcap::Chunk& chunk, LostStretch& stretch) {
  if (chunk.start_time_ns > chunk.end_time_ns || chunk.end_time_ns == 0) return;
  stretch.from_ns = chunk.start_time_ns;
  stretch.to_ns = chunk.end_time_ns;
}

std::string bytes_text(std::uint64_t from, std::uint64_t count) {
  return "bytes " + std::to_string(from) + " to " + std::to_string(from + count);
}

}  // namespace

Recoverer::Recoverer(mcap::Readable& in, mcap::Writable& out, const RecoverOptions& options)
    : in_(in),
      writer_(out),
      options_(options),
      scanner_(in, std::min<std::uint64_t>(mcap::kMagic.size(), in.size()), options.reader) {
  recovery_.input_bytes = in.size();
}

Result<Recovery> Recoverer::run() {
  const auto magic = mcap::check_opening_magic(in_);
  if (!magic && (magic.error().code != ErrorCode::corrupt || in_.size() < mcap::kMagic.size())) return magic.error();
  if (magic) input_crc_ = mcap::crc32(0, mcap::kMagic);
  if (!magic) remark("the first eight bytes, which say that this is an MCAP file, were damaged");
  if (auto read = read_records(); !read) return read.error();
  if (!begun_) return magic ? Error{ErrorCode::truncated, "holds nothing but its first bytes"} : magic.error();
  if (auto flushed = flush_loose(); !flushed) return flushed.error();
  if (auto finished = finish(); !finished) return finished.error();
  return std::move(recovery_);
}

bool Recoverer::go_on(std::uint64_t offset) {
  if (!options_.progress || offset < next_progress_) return true;
  next_progress_ = offset + kProgressStep;
  return options_.progress(static_cast<double>(offset) / static_cast<double>(in_.size()));
}

Result<void> Recoverer::read_records() {
  while (!ended_) {
    auto found = scanner_.next();
    if (!found) return found.error();
    if (!*found) return {};
    Result<void> taken;
    if (const auto* hole = std::get_if<Hole>(&**found)) {
      taken = take_hole(*hole);
      chunk_was_lost_ = true;
      if (!go_on(hole->offset + hole->bytes)) return Error{ErrorCode::io, "stopped"};
    } else {
      const auto& place = std::get<RecordPlace>(**found);
      taken = take(place);
      if (!go_on(place.end())) return Error{ErrorCode::io, "stopped"};
    }
    if (!taken) return taken;
  }
  return {};
}

Result<void> Recoverer::take(const RecordPlace& place) {
  if (!begun_ && place.opcode != code(Opcode::header)) {
    remark("the header record was missing");
    if (auto begun = writer_.begin({}); !begun) return begun;
    begun_ = true;
  }
  if (place.opcode != code(Opcode::message_index)) chunk_was_lost_ = false;
  if (place.opcode != code(Opcode::message)) {
    if (auto flushed = flush_loose(); !flushed) return flushed;
  }
  if (place.opcode == code(Opcode::chunk)) return take_chunk(place);
  const auto content = scanner_.content(place);
  if (!content) return content.error();
  auto record = mcap::decode(place.opcode, *content);
  if (!record) return reject(place, record.error().message);
  if (place.opcode != code(Opcode::data_end)) add_input_crc(place, *content);
  const std::size_t stretches = losses_.stretches().size();
  auto taken = take_decoded(place, std::move(*record), *content);
  if (!ended_ && losses_.stretches().size() == stretches) readable_end_ = place.end();
  return taken;
}

Result<void> Recoverer::take_decoded(const RecordPlace& place, mcap::Record record, std::span<const std::byte> content) {
  if (const auto* header = std::get_if<mcap::Header>(&record)) {
    if (std::exchange(begun_, true)) return {};
    return writer_.begin(*header);
  }
  if (const auto* schema = std::get_if<mcap::Schema>(&record)) return define(*schema, place);
  if (const auto* channel = std::get_if<mcap::Channel>(&record)) return define(*channel, place);
  if (const auto* message = std::get_if<mcap::Message>(&record)) return add_loose(*message, place);
  if (const auto* attachment = std::get_if<mcap::Attachment>(&record)) return take_attachment(place, *attachment, content);
  if (const auto* other = std::get_if<mcap::OtherRecord>(&record)) return take_other(place, *other);
  if (const auto* data_end = std::get_if<mcap::DataEnd>(&record)) return end_data(place, *data_end);
  if (const auto* index = std::get_if<mcap::MessageIndex>(&record)) {
    if (chunk_was_lost_) losses_.lose_indexed(index->channel_id, index->entries.size());
    return {};
  }
  if (const auto* metadata = std::get_if<mcap::Metadata>(&record)) {
    ++recovery_.metadata;
    if (metadata->name == mcap::kCountersMetadata) {
      has_final_counters_ = true;
      losses_.count(*metadata);
    }
    return writer_.write(*metadata);
  }
  if (std::holds_alternative<mcap::Footer>(record)) {
    ended_ = true;
    remark("the data section had no end record");
  }
  return {};  // indexes of a summary: they are made anew
}

Result<void> Recoverer::take_other(const RecordPlace& place, const mcap::OtherRecord& record) {
  if (place.opcode == code(mcap::kCheckpointOpcode)) {
    ++recovery_.checkpoints;
    if (const auto metadata = mcap::decode_metadata(record.content)) losses_.count(*metadata);
  }
  return writer_.write(record);
}

Result<void> Recoverer::take_attachment(const RecordPlace& place, const mcap::Attachment& attachment,
                                        std::span<const std::byte> content) {
  if (auto checked = mcap::check_attachment_crc(attachment, content); !checked) {
    input_crc_.reset();
    return reject(place, "attachment '" + attachment.name + "': its CRC does not match");
  }
  ++recovery_.attachments;
  return writer_.write(attachment);
}

// ---------------------------------------------------------------------------------------------------------------------
// Schemas and channels

Result<void> Recoverer::define(const mcap::Schema& schema, const RecordPlace& place) {
  if (auto added = catalog_.add(schema); !added) {
    losses_.lose({.offset = place.offset, .bytes = place.end() - place.offset, .reason = added.error().message});
    return {};
  }
  return writer_.write(schema);
}

Result<void> Recoverer::define(const mcap::Channel& channel, const RecordPlace& place) {
  if (channel.schema_id != 0) {
    const auto known = ensure_schema(channel.schema_id);
    if (!known) return known.error();
  }
  if (auto added = catalog_.add(channel); !added) {
    losses_.lose({.offset = place.offset, .bytes = place.end() - place.offset, .reason = added.error().message});
    return {};
  }
  losses_.name(channel.id, channel.topic);
  return writer_.write(channel);
}

/// Looks into the whole file, its summary too, for definitions.
Result<void> Recoverer::search_definitions() {
  if (elsewhere_) return {};
  elsewhere_.emplace();
  RecordScanner scanner(in_, std::min<std::uint64_t>(mcap::kMagic.size(), in_.size()), options_.reader);
  std::vector<mcap::Channel> channels;  // their schemas may stand behind them in a damaged file
  std::vector<std::byte> buffer;
  while (true) {
    const auto found = scanner.next();
    if (!found) return found.error();
    if (!*found) break;
    const auto* place = std::get_if<RecordPlace>(&**found);
    if (place == nullptr) continue;
    if (place->opcode != code(Opcode::schema) && place->opcode != code(Opcode::channel) &&
        place->opcode != code(Opcode::chunk)) {
      continue;
    }
    const auto content = scanner.content(*place);
    if (!content) return content.error();
    const auto record = mcap::decode(place->opcode, *content);
    if (!record) continue;
    // The first definition counts, as everywhere.
    if (const auto* schema = std::get_if<mcap::Schema>(&*record)) static_cast<void>(elsewhere_->add(*schema).has_value());
    if (const auto* channel = std::get_if<mcap::Channel>(&*record)) channels.push_back(*channel);
    const auto* chunk = std::get_if<mcap::Chunk>(&*record);
    if (chunk == nullptr) continue;
    const auto records = mcap::chunk_records(*chunk, buffer, options_.reader);
    if (!records) continue;
    const auto inside = mcap::chunk_content(*records);
    for (const auto& schema : inside.schemas) static_cast<void>(elsewhere_->add(schema).has_value());
    channels.insert(channels.end(), inside.channels.begin(), inside.channels.end());
  }
  for (const auto& channel : channels) static_cast<void>(elsewhere_->add(channel).has_value());
  return {};
}

Result<bool> Recoverer::ensure_schema(std::uint16_t id) {
  if (catalog_.schemas().contains(id)) return true;
  if (auto searched = search_definitions(); !searched) return searched.error();
  const auto found = elsewhere_->schemas().find(id);
  if (found == elsewhere_->schemas().end()) return false;
  if (!catalog_.add(found->second)) return false;
  remark("schema '" + found->second.name + "' was lost where it belongs and taken from further behind in the file");
  if (auto written = writer_.write(found->second); !written) return written.error();
  return true;
}

Result<bool> Recoverer::ensure_channel(std::uint16_t id) {
  if (catalog_.channel(id) != nullptr) return true;
  if (auto searched = search_definitions(); !searched) return searched.error();
  const mcap::Channel* channel = elsewhere_->channel(id);
  if (channel == nullptr) return false;
  if (channel->schema_id != 0) {
    const auto schema = ensure_schema(channel->schema_id);
    if (!schema || !*schema) return schema;
  }
  if (!catalog_.add(*channel)) return false;
  losses_.name(id, channel->topic);
  remark("channel '" + channel->topic + "' was lost where it belongs and taken from further behind in the file");
  if (auto written = writer_.write(*channel); !written) return written.error();
  return true;
}

// ---------------------------------------------------------------------------------------------------------------------
// Chunks

Result<void> Recoverer::take_chunk(const RecordPlace& place) {
  const auto content = scanner_.content(place);
  if (!content) return content.error();
  auto record = mcap::decode(place.opcode, *content);
  if (!record) return reject(place, record.error().message);
  auto& chunk = std::get<mcap::Chunk>(*record);
  const auto records = mcap::chunk_records(chunk, decompressed_, options_.reader);
  if (!records) return reject(place, records.error().message);

  const bool compressed = !chunk.compression.empty();
  if (chunk.uncompressed_crc == 0) chunk.uncompressed_crc = mcap::crc32(0, *records);
  const std::uint32_t stored_crc = compressed ? mcap::crc32(0, chunk.records) : chunk.uncompressed_crc;
  add_input_crc_of_chunk(place, *content, chunk, stored_crc);
  const auto inside = mcap::chunk_content(*records);
  std::vector<std::uint16_t> refused;
  auto fault = adopt_definitions(inside, refused);
  if (!fault) return fault.error();
  if (inside.fault && fault->empty()) *fault = inside.fault->message;
  readable_end_ = place.end();
  if (!fault->empty()) return rebuild_chunk(place, chunk, inside, *records, *fault);
  for (const auto& message : inside.messages) losses_.keep(message);
  ++recovery_.chunks;
  return writer_.copy(chunk, stored_crc, inside);
}

/// Makes sure that every message's channel is described. Empty, or what is wrong; the channels that cannot be used.
Result<std::string> Recoverer::adopt_definitions(const mcap::ChunkContent& content, std::vector<std::uint16_t>& refused) {
  std::string fault;
  for (const auto& schema : content.schemas) {
    if (auto added = catalog_.add(schema); !added) fault = added.error().message;
  }
  for (const auto& channel : content.channels) {
    if (channel.schema_id != 0) {
      const auto known = ensure_schema(channel.schema_id);
      if (!known) return known.error();
    }
    if (auto added = catalog_.add(channel); !added) {
      fault = added.error().message;
      refused.push_back(channel.id);
    } else {
      losses_.name(channel.id, channel.topic);
    }
  }
  std::optional<std::uint16_t> last;
  for (const auto& message : content.messages) {
    if (last == message.channel_id) continue;
    last = message.channel_id;
    const auto known = ensure_channel(message.channel_id);
    if (!known) return known.error();
    if (*known) continue;
    fault = "messages of channel " + std::to_string(message.channel_id) + ", which nothing in the file describes";
    refused.push_back(message.channel_id);
  }
  return fault;
}

/// The chunk without what cannot stay in it.
Result<void> Recoverer::rebuild_chunk(const RecordPlace& place, const mcap::Chunk& chunk, const mcap::ChunkContent& content,
                                      std::span<const std::byte> records, const std::string& reason) {
  mcap::ChunkBuilder builder(*mcap::compression_from_string(chunk.compression));
  for (const auto& schema : content.schemas) {
    const auto known = catalog_.schemas().find(schema.id);
    if (known != catalog_.schemas().end()) builder.add(known->second);
  }
  for (const auto& channel : content.channels) {
    if (const auto* known = catalog_.channel(channel.id)) builder.add(*known);
  }
  LostStretch stretch{.offset = place.offset, .reason = "in the chunk: " + reason};
  std::vector<std::uint16_t> refused;
  for (const auto& channel : content.channels) {
    const auto* known = catalog_.channel(channel.id);
    if (known == nullptr || known->topic != channel.topic || known->schema_id != channel.schema_id)
      refused.push_back(channel.id);
  }
  std::vector<mcap::ChunkContent::MessageEntry> kept;
  for (const auto& entry : content.messages) {
    const auto message = message_at(records, entry.offset);
    const auto* channel = catalog_.channel(entry.channel_id);
    if (channel == nullptr || std::ranges::find(refused, entry.channel_id) != refused.end()) {
      stretch.bytes += mcap::kMessageHeadBytes + message.data.size();
      ++stretch.messages[channel != nullptr ? channel->topic : "channel " + std::to_string(entry.channel_id)];
      continue;
    }
    builder.add(message);
    kept.push_back(entry);
  }
  losses_.lose(std::move(stretch));
  for (const auto& entry : kept) losses_.keep(entry);
  ++recovery_.chunks;
  return writer_.write(builder);
}

Result<void> Recoverer::add_loose(const mcap::Message& message, const RecordPlace& place) {
  const auto known = ensure_channel(message.channel_id);
  if (!known) return known.error();
  if (!*known) {
    losses_.lose(
        {.offset = place.offset,
         .bytes = place.end() - place.offset,
         .reason = "a message of channel " + std::to_string(message.channel_id) + ", which nothing in the file describes"});
    return {};
  }
  losses_.keep({message.channel_id, message.sequence, message.log_time_ns, 0});
  loose_.add(message);
  return loose_.uncompressed_bytes() >= kLooseChunkBytes ? flush_loose() : Result<void>{};
}

Result<void> Recoverer::flush_loose() {
  if (loose_.empty()) return {};
  auto written = writer_.write(loose_);
  loose_.clear();
  ++recovery_.chunks;
  return written;
}

// ---------------------------------------------------------------------------------------------------------------------
// What is lost

Result<void> Recoverer::reject(const RecordPlace& place, const std::string& reason) {
  auto hole = scanner_.reject(place, reason);
  if (!hole) return hole.error();
  auto taken = take_hole(*hole);
  chunk_was_lost_ = place.opcode == code(Opcode::chunk);
  return taken;
}

Result<void> Recoverer::take_hole(const Hole& hole) {
  input_crc_.reset();
  LostStretch stretch{.offset = hole.offset, .bytes = hole.bytes, .reason = hole.reason};
  std::uint64_t saved = 0;
  if (begun_) {
    if (auto flushed = flush_loose(); !flushed) return flushed;
    auto torn = save_torn_chunk(hole, stretch);
    if (!torn) return torn.error();
    saved = *torn;
  }
  stretch.saved_messages = saved;
  recovery_.unchecked_messages += saved;
  losses_.lose(std::move(stretch));
  return {};
}

/// The head of the chunk that the hole begins with, and how many bytes of records it announces.
Result<std::optional<Recoverer::TornChunk>> Recoverer::read_torn_head(const Hole& hole) {
  constexpr std::uint64_t kFixed = 40;
  constexpr std::uint64_t kMostName = 16;
  const std::uint64_t content = std::min(hole.bytes, mcap::kRecordHeadBytes + kFixed + kMostName);
  const auto front = scanner_.bytes(hole.offset, content);
  if (!front) return front.error();
  if (content < mcap::kRecordHeadBytes + kFixed || (*front)[0] != static_cast<std::byte>(Opcode::chunk)) {
    return std::optional<TornChunk>{};
  }
  std::uint32_t name_bytes = 0;
  std::memcpy(&name_bytes, front->data() + mcap::kRecordHeadBytes + 28, sizeof name_bytes);
  if (name_bytes > kMostName || mcap::kRecordHeadBytes + kFixed + name_bytes > content) return std::optional<TornChunk>{};
  // Read as if it were the whole of a chunk that holds nothing.
  TornChunk torn{.head_bytes = mcap::kRecordHeadBytes + kFixed + name_bytes};
  std::vector<std::byte> head(front->begin() + mcap::kRecordHeadBytes,
                              front->begin() + static_cast<std::ptrdiff_t>(torn.head_bytes));
  const auto length = std::span(head).last(sizeof torn.records_bytes);
  std::memcpy(&torn.records_bytes, length.data(), length.size());
  std::ranges::fill(length, std::byte{0});
  auto record = mcap::decode(code(Opcode::chunk), head);
  if (!record) return std::optional<TornChunk>{};
  torn.head = std::get<mcap::Chunk>(std::move(*record));
  torn.head.records = {};
  return std::optional(std::move(torn));
}

/// Of a chunk at the end of a cut file the messages that are all there, when it is not compressed. How many.
Result<std::uint64_t> Recoverer::save_torn_chunk(const Hole& hole, LostStretch& stretch) {
  const auto found = read_torn_head(hole);
  if (!found) return found.error();
  if (!*found) return std::uint64_t{0};
  const TornChunk& torn = **found;
  take_times(torn.head, stretch);
  const std::uint64_t there = hole.bytes - torn.head_bytes;
  const bool is_torn = hole.offset + hole.bytes == in_.size() && there < torn.records_bytes;
  if (!is_torn || there > std::min(options_.reader.max_chunk_bytes, options_.reader.max_record_bytes)) return std::uint64_t{0};
  if (!torn.head.compression.empty()) {
    stretch.reason += " (compressed: what is there of it does not read)";
    return std::uint64_t{0};
  }
  const auto records = scanner_.bytes(hole.offset + torn.head_bytes, there);
  if (!records) return records.error();
  const auto inside = mcap::chunk_content(*records);
  mcap::ChunkBuilder builder;
  std::uint64_t saved = 0;
  for (const auto& entry : inside.messages) {
    const bool in_time = entry.log_time_ns >= torn.head.start_time_ns && entry.log_time_ns <= torn.head.end_time_ns;
    if (!in_time || catalog_.channel(entry.channel_id) == nullptr) break;
    builder.add(message_at(*records, entry.offset));
    losses_.keep(entry);
    ++saved;
  }
  if (saved == 0) return saved;
  stretch.from_ns = builder.end_time_ns();
  if (auto written = writer_.write(builder); !written) return written.error();
  ++recovery_.chunks;
  return saved;
}

void Recoverer::add_input_crc(const RecordPlace& place, std::span<const std::byte> content) {
  if (input_crc_) input_crc_ = mcap::crc32(mcap::crc32(*input_crc_, head_bytes(place)), content);
}

void Recoverer::add_input_crc_of_chunk(const RecordPlace& place, std::span<const std::byte> content, const mcap::Chunk& chunk,
                                       std::uint32_t stored_crc) {
  if (!input_crc_) return;
  const std::size_t before = static_cast<std::size_t>(chunk.records.data() - content.data());
  const auto behind = content.subspan(before + chunk.records.size());
  std::uint32_t crc = mcap::crc32(mcap::crc32(*input_crc_, head_bytes(place)), content.first(before));
  crc = mcap::crc32_combine(crc, stored_crc, chunk.records.size());
  input_crc_ = mcap::crc32(crc, behind);
}

// ---------------------------------------------------------------------------------------------------------------------
// The end

Result<void> Recoverer::end_data(const RecordPlace& place, const mcap::DataEnd& data_end) {
  ended_ = true;
  readable_end_ = place.offset;
  if (input_crc_ && data_end.data_section_crc != 0 && *input_crc_ != data_end.data_section_crc) {
    remark(
        "the data section's CRC does not match, although every chunk and attachment does: a byte outside of them has changed "
        "(metadata, a schema, a channel, a message index or a chunk's head)");
  }
  if (auto ending = mcap::check_ending(in_); !ending) {
    remark("the index at the file's end was missing or damaged: " + ending.error().message);
    return {};
  }
  read_old_statistics(place);
  return {};
}

/// The file's own counts: what they say beyond what was found is lost.
void Recoverer::read_old_statistics(const RecordPlace& data_end) {
  mcap::RecordReader records(in_, data_end.end(), in_.size());
  while (true) {
    const auto place = records.next();
    if (!place || !*place || (*place)->opcode == code(Opcode::footer)) return;
    if ((*place)->opcode != code(Opcode::statistics)) continue;
    const auto record = records.decode(**place);
    if (record) losses_.set_statistics(std::get<mcap::Statistics>(*record));
    return;
  }
}

/// What was lost stays with the file, for whoever analyses it.
Result<void> Recoverer::write_what_was_done() {
  mcap::Metadata metadata{std::string(kRecoveredMetadata), {}};
  metadata.metadata["input_bytes"] = std::to_string(in_.size());
  metadata.metadata["lost_bytes"] = std::to_string(recovery_.lost_bytes);
  metadata.metadata["unchecked_messages"] = std::to_string(recovery_.unchecked_messages);
  std::size_t number = 0;
  for (const LostStretch& stretch : recovery_.lost) {
    constexpr std::size_t kMost = 1000;
    if (++number > kMost) break;
    metadata.metadata["lost_" + std::to_string(number)] = bytes_text(stretch.offset, stretch.bytes) + ": " + stretch.reason;
  }
  for (const TopicRecovery& topic : recovery_.topics) {
    if (topic.lost > 0) metadata.metadata["lost " + topic.topic] = std::to_string(topic.lost);
  }
  return writer_.write(metadata);
}

Result<void> Recoverer::finish() {
  if (const auto mended = scanner_.mended_lengths(); mended > 0) {
    remark(std::to_string(mended) + " records said a wrong length: what follows them, or their CRC, told the right one");
  }
  if (!ended_) remark("the file was cut off: its index has been made anew");
  recovery_.topics = losses_.topics();
  recovery_.lost = losses_.stretches();
  for (const LostStretch& stretch : recovery_.lost) recovery_.lost_bytes += stretch.bytes;
  recovery_.messages = losses_.messages();
  recovery_.last_message_ns = losses_.last_message_ns();
  recovery_.was_whole = recovery_.lost.empty() && recovery_.remarks.empty();
  if (!recovery_.was_whole) {
    if (auto written = write_what_was_done(); !written) return written;
    const auto counters = losses_.final_counters();
    if (counters && !has_final_counters_) {
      if (auto written = writer_.write(*counters); !written) return written;
    }
  }
  if (auto finished = writer_.finish(); !finished) return finished;
  recovery_.output_bytes = writer_.bytes_written();
  return {};
}

}  // namespace roseau::recorder
