#include "recorder/format/record_reader.h"

#include <algorithm>
#include <string>

namespace roseau::mcap {

namespace {

constexpr std::uint64_t kWindowBytes = 64U << 10U;

/// The rules for what may stand at `position`, with `head` null when fewer than nine bytes are left.
Result<std::optional<RecordPlace>> place_record(const RecordHead* head, std::uint64_t position, std::uint64_t end) {
  if (position == end) return std::optional<RecordPlace>{};
  if (head == nullptr)
    return Error{ErrorCode::truncated, "ends in the middle of a record, at byte " + std::to_string(position)};
  if (head->opcode == 0) return Error{ErrorCode::corrupt, "holds no record at byte " + std::to_string(position)};
  if (head->content_bytes > end - position - kRecordHeadBytes) {
    return Error{ErrorCode::truncated, "ends in the middle of a " + name_of(head->opcode) + " record that begins at byte " +
                                           std::to_string(position)};
  }
  return std::optional(RecordPlace{head->opcode, position, head->content_bytes});
}

}  // namespace

Result<std::optional<RecordPlace>> next_record(std::span<const std::byte> records, std::uint64_t& position) {
  RecordHead head;
  const bool has_head = records.size() - position >= kRecordHeadBytes;
  if (has_head) head = decode_head(records.subspan(position));
  auto place = place_record(has_head ? &head : nullptr, position, records.size());
  position = place && *place ? (*place)->end() : records.size();
  return place;
}

Result<std::optional<RecordPlace>> RecordReader::next() {
  RecordHead head;
  const bool has_head = end_ - position_ >= kRecordHeadBytes;
  if (has_head) {
    const auto head_bytes = bytes(position_, kRecordHeadBytes);
    if (!head_bytes) return head_bytes.error();
    head = decode_head(*head_bytes);
  }
  auto place = place_record(has_head ? &head : nullptr, position_, end_);
  if (place && *place) position_ = (*place)->end();
  if (!place) end_ = position_;
  return place;
}

Result<std::span<const std::byte>> RecordReader::bytes(std::uint64_t offset, std::uint64_t size) {
  ROSEAU_CHECK(offset <= in_.size() && size <= in_.size() - offset);
  if (size > max_record_bytes_) {
    return Error{ErrorCode::unsupported, "the record at byte " + std::to_string(offset) + " has " + std::to_string(size) +
                                             " bytes, more than this program reads at once"};
  }
  if (size > kWindowBytes) {
    if (size > large_.capacity()) std::vector<std::byte>().swap(large_);  // nothing in it is to be kept
    large_.resize(size);
    if (auto read = in_.read(offset, large_); !read) return read.error();
    return std::span<const std::byte>(large_);
  }
  const bool inside = offset >= window_offset_ && offset + size <= window_offset_ + window_.size();
  if (!inside) {
    window_.resize(std::min(kWindowBytes, in_.size() - offset));
    window_offset_ = offset;
    if (auto read = in_.read(offset, window_); !read) {
      window_.clear();
      return read.error();
    }
  }
  return std::span<const std::byte>(window_).subspan(offset - window_offset_, size);
}

Result<Record> RecordReader::decode(const RecordPlace& place) {
  const auto bytes = content(place);
  if (!bytes) return bytes.error();
  auto record = mcap::decode(place.opcode, *bytes);
  if (!record) return record.error().with_context("at byte " + std::to_string(place.offset));
  return record;
}

}  // namespace roseau::mcap
