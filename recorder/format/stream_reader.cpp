#include "recorder/format/stream_reader.h"

#include <algorithm>
#include <array>

#include "recorder/format/crc32.h"

namespace roseau::mcap {

namespace {
std::string at_byte(std::uint64_t offset) { return "at byte " + std::to_string(offset); }

bool belongs_in_chunk(const Record& record) {
  return std::holds_alternative<Schema>(record) || std::holds_alternative<Channel>(record) ||
         std::holds_alternative<Message>(record) || std::holds_alternative<OtherRecord>(record);
}
}  // namespace

Result<void> check_opening_magic(Readable& in) {
  std::array<std::byte, kMagic.size()> magic{};
  if (in.size() < magic.size()) {
    return Error{in.size() == 0 ? ErrorCode::truncated : ErrorCode::corrupt,
                 in.size() == 0 ? "is empty: nothing was recorded" : "is not an MCAP file (too short)"};
  }
  if (auto read = in.read(0, magic); !read) return read;
  if (magic == kMagic) return {};
  auto as_version_0 = magic;
  constexpr std::size_t kVersionByte = 5;
  as_version_0[kVersionByte] = kMagic[kVersionByte];
  if (as_version_0 == kMagic) {
    return Error{ErrorCode::unsupported, std::string("is MCAP of major version '") + static_cast<char>(magic[kVersionByte]) +
                                             "', this program reads version '0': use a newer program"};
  }
  return Error{ErrorCode::corrupt, "is not an MCAP file"};
}

StreamReader::StreamReader(Readable& in, ReaderOptions options)
    : in_(in),
      options_(options),
      records_(in, std::min<std::uint64_t>(kMagic.size(), in.size()), in.size(), options.max_record_bytes) {}

Result<std::optional<Record>> StreamReader::end_here(const Error& error) {
  ended_ = true;
  ending_ = error.message;
  if (error.code == ErrorCode::truncated) return std::optional<Record>{};
  return error;
}

Result<std::optional<Record>> StreamReader::next() {
  if (ended_) return std::optional<Record>{};
  if (!begun_) {
    begun_ = true;
    if (auto magic = check_opening_magic(in_); !magic) return end_here(magic.error());
    section_crc_ = crc32(0, kMagic);
  }
  while (true) {
    if (!chunk_.empty()) {
      auto record = next_in_chunk();
      if (!record || *record) return record;
      continue;
    }
    const auto place = records_.next();
    if (!place) return end_here(place.error());
    if (!*place) return end_here({ErrorCode::truncated, "ends without a footer, " + at_byte(records_.position())});
    auto record = take(**place);
    if (!record || *record) return record;
  }
}

/// Nothing when the record is not for the caller.
Result<std::optional<Record>> StreamReader::take(const RecordPlace& place) {
  const auto content = records_.content(place);
  if (!content && content.error().code == ErrorCode::unsupported) return content.error();  // too large: the rest reads
  if (!content) return end_here(content.error());
  if (place.opcode != static_cast<std::uint8_t>(Opcode::data_end) &&
      place.opcode != static_cast<std::uint8_t>(Opcode::footer)) {
    update_crc(place, *content);
  }
  auto record = decode(place.opcode, *content);
  if (!record) return record.error().with_context(at_byte(place.offset));
  if (auto checked = check(*record, place, *content); !checked) return checked.error().with_context(at_byte(place.offset));
  if (const auto* chunk = std::get_if<Chunk>(&*record)) {
    if (auto opened = open_chunk(place, *chunk); !opened) return opened.error().with_context(at_byte(place.offset));
    return std::optional<Record>{};
  }
  if (std::holds_alternative<MessageIndex>(*record)) return std::optional<Record>{};
  return std::optional<Record>(std::move(*record));
}

void StreamReader::update_crc(const RecordPlace& place, std::span<const std::byte> content) {
  std::array<std::byte, kRecordHeadBytes> head{};
  head[0] = static_cast<std::byte>(place.opcode);
  for (std::size_t i = 0; i < 8; ++i) head[1 + i] = static_cast<std::byte>(place.content_bytes >> (8 * i));
  section_crc_ = crc32(crc32(section_crc_, head), content);
}

Result<void> StreamReader::open_chunk(const RecordPlace& place, const Chunk& chunk) {
  auto records = chunk_records(chunk, chunk_buffer_, options_);
  if (!records) return records.error();
  // A chunk stored as it is lies in the record reader's buffer, which stays as it is until the chunk is used up.
  chunk_ = *records;
  chunk_position_ = 0;
  chunk_offset_ = place.offset;
  return {};
}

Result<std::optional<Record>> StreamReader::next_in_chunk() {
  const auto place = next_record(chunk_, chunk_position_);
  if (!place || !*place) {
    chunk_ = {};
    if (!place) return Error{ErrorCode::corrupt, "the chunk " + at_byte(chunk_offset_) + " " + place.error().message};
    return std::optional<Record>{};
  }
  const auto content = chunk_.subspan((*place)->content_offset(), (*place)->content_bytes);
  auto record = decode((*place)->opcode, content);
  const auto context = [&] { return "in the chunk " + at_byte(chunk_offset_); };
  if (!record) return record.error().with_context(context());
  if (!belongs_in_chunk(*record)) return Error{ErrorCode::corrupt, "a " + name_of((*place)->opcode) + " " + context()};
  if (auto checked = check(*record, **place, content); !checked) return checked.error().with_context(context());
  return std::optional<Record>(std::move(*record));
}

Result<void> StreamReader::check(const Record& record, const RecordPlace& place, std::span<const std::byte> content) {
  if (const auto* schema = std::get_if<Schema>(&record)) return catalog_.add(*schema);
  if (const auto* channel = std::get_if<Channel>(&record)) return catalog_.add(*channel);
  if (const auto* attachment = std::get_if<Attachment>(&record)) return check_attachment_crc(*attachment, content);
  if (const auto* footer = std::get_if<Footer>(&record)) return check_footer(*footer, place);
  if (const auto* message = std::get_if<Message>(&record)) {
    if (catalog_.channel(message->channel_id) != nullptr) return {};
    return Error{ErrorCode::corrupt,
                 "a message of channel " + std::to_string(message->channel_id) + ", which is not described"};
  }
  if (const auto* data_end = std::get_if<DataEnd>(&record)) {
    const bool wrong = data_end->data_section_crc != 0 && data_end->data_section_crc != section_crc_;
    section_crc_ = 0;
    summary_start_ = place.end();
    if (wrong)
      return Error{ErrorCode::corrupt, "the data section's CRC does not match: bytes have changed since they were written"};
  }
  return {};
}

Result<void> StreamReader::check_footer(const Footer& footer, const RecordPlace& place) {
  ended_ = true;
  std::array<std::byte, kMagic.size()> magic{};
  complete_ = in_.size() - place.end() >= magic.size() && in_.read(place.end(), magic) && magic == kMagic;
  if (!complete_) ending_ = "ends without its closing magic, " + at_byte(place.end());
  if (summary_start_ == 0) return Error{ErrorCode::corrupt, "the data section has no end record"};
  if (footer.summary_start != summary_start_ && footer.summary_start != 0) {
    return Error{ErrorCode::corrupt, "the footer does not point to the summary"};
  }
  if (footer.summary_crc != 0 && crc32(section_crc_, footer_prefix(footer)) != footer.summary_crc) {
    return Error{ErrorCode::corrupt, "the summary's CRC does not match: bytes have changed since they were written"};
  }
  return {};
}

}  // namespace roseau::mcap
