#include "recorder/format/chunk_content.h"

#include <algorithm>
#include <string>
#include <utility>

#include "recorder/format/codec.h"
#include "recorder/format/record_reader.h"

namespace roseau::mcap {

namespace {

void add(const Message& message, std::uint64_t offset, ChunkContent& content) {
  const bool first = content.messages.empty();
  content.start_time_ns = first ? message.log_time_ns : std::min(content.start_time_ns, message.log_time_ns);
  content.end_time_ns = first ? message.log_time_ns : std::max(content.end_time_ns, message.log_time_ns);
  content.messages.push_back({message.channel_id, message.sequence, message.log_time_ns, offset});
}

void note(ChunkContent& content, Error error) {
  if (!content.fault) content.fault = std::move(error);
}

}  // namespace

std::map<std::uint16_t, MessageIndex> ChunkContent::indexes() const {
  std::map<std::uint16_t, MessageIndex> indexes;
  for (const MessageEntry& message : messages) {
    MessageIndex& index = indexes[message.channel_id];
    index.channel_id = message.channel_id;
    index.entries.emplace_back(message.log_time_ns, message.offset);
  }
  return indexes;
}

ChunkContent chunk_content(std::span<const std::byte> records) {
  ChunkContent content;
  std::uint64_t position = 0;
  while (true) {
    const auto place = next_record(records, position);
    if (!place) note(content, place.error());
    if (!place || !*place) return content;
    auto record = decode((*place)->opcode, records.subspan((*place)->content_offset(), (*place)->content_bytes));
    if (!record) {
      note(content, record.error());
    } else if (const auto* message = std::get_if<Message>(&*record)) {
      add(*message, (*place)->offset, content);
    } else if (auto* schema = std::get_if<Schema>(&*record)) {
      content.schemas.push_back(std::move(*schema));
    } else if (auto* channel = std::get_if<Channel>(&*record)) {
      content.channels.push_back(std::move(*channel));
    } else if (!std::holds_alternative<OtherRecord>(*record)) {
      note(content, {ErrorCode::corrupt, "holds a " + name_of((*place)->opcode) + " record, which may not stand in a chunk"});
    }
  }
}

}  // namespace roseau::mcap
