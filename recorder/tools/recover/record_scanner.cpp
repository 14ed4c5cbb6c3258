#include "recorder/tools/recover/record_scanner.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "recorder/format/compression.h"
#include "recorder/format/crc32.h"

namespace roseau::recorder {

namespace {

using mcap::kRecordHeadBytes;
using mcap::Opcode;
using mcap::RecordPlace;

constexpr std::uint64_t kSearchWindowBytes = 1U << 20U;
constexpr std::uint64_t kMostSmallBytes = 64U << 20U;  // of a record whose content is decoded to see whether it is one
constexpr std::uint64_t kChunkFixedBytes = 8 + 8 + 8 + 4 + 4 + 8;
constexpr std::uint64_t kAttachmentFixedBytes = 8 + 8 + 4 + 4 + 8 + 4;
constexpr std::uint64_t kMostCompressionName = 16;
constexpr int kChainLength = 3;

bool is_known(std::uint8_t opcode) {
  return (opcode >= 1 && opcode <= static_cast<std::uint8_t>(Opcode::data_end)) ||
         opcode >= static_cast<std::uint8_t>(Opcode::first_private);
}

template <class T>
T number_at(std::span<const std::byte> bytes, std::size_t offset) {
  T value{};
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

/// How many bytes the fields that we know fill.
std::uint64_t filled_bytes(const mcap::Record& record) {
  return std::visit(
      [](const auto& one) -> std::uint64_t {
        using T = std::decay_t<decltype(one)>;
        if constexpr (std::is_same_v<T, mcap::Message>) {
          return mcap::kMessageHeadBytes - kRecordHeadBytes + one.data.size();
        } else if constexpr (std::is_same_v<T, mcap::OtherRecord>) {
          return one.content.size();
        } else if constexpr (std::is_same_v<T, mcap::Chunk>) {
          return kChunkFixedBytes + one.compression.size() + one.records.size();
        } else {
          std::vector<std::byte> bytes;
          encode(one, bytes);
          return bytes.size() - kRecordHeadBytes;
        }
      },
      record);
}

}  // namespace

RecordScanner::RecordScanner(mcap::Readable& in, std::uint64_t offset, const mcap::ReaderOptions& options)
    : in_(in),
      options_(options),
      position_(offset),
      end_(in.size()),
      search_budget_bytes_(8 * in.size() + (std::uint64_t{256} << 20U)),
      records_(in, offset, in.size(), options.max_record_bytes),
      probe_(in, offset, in.size(), options.max_record_bytes) {}

Result<mcap::RecordHead> RecordScanner::head(std::uint64_t offset) {
  const auto bytes = probe_.bytes(offset, kRecordHeadBytes);
  if (!bytes) return bytes.error();
  return mcap::decode_head(*bytes);
}

Result<std::optional<RecordScanner::Found>> RecordScanner::next() {
  if (position_ >= end_) return std::optional<Found>{};
  const std::uint64_t offset = position_;
  auto candidate = look(offset);
  if (!candidate) return candidate.error();
  if (!candidate->is_record) {
    if (auto mended = mend_chunk(offset); !mended) {
      return mended.error();
    } else if (*mended) {
      position_ = (*mended)->end();
      ++mended_lengths_;
      return std::optional<Found>(**mended);
    }
    auto hole = hole_from(offset, std::move(candidate->reason));
    if (!hole) return hole.error();
    return std::optional<Found>(std::move(*hole));
  }
  const auto record_head = head(offset);
  if (!record_head) return record_head.error();
  position_ = candidate->end;
  if (position_ != offset + kRecordHeadBytes + record_head->content_bytes) ++mended_lengths_;
  return std::optional<Found>(RecordPlace{record_head->opcode, offset, candidate->end - offset - kRecordHeadBytes});
}

Result<Hole> RecordScanner::hole_from(std::uint64_t offset, std::string reason) {
  const auto next = find_sure(offset + 1, end_);
  if (!next) return next.error();
  position_ = next->value_or(end_);
  return Hole{offset, position_ - offset, std::move(reason)};
}

Result<Hole> RecordScanner::reject(const RecordPlace& place, const std::string& reason) {
  const auto follows = head_is_plausible(place.end());
  if (!follows) return follows.error();
  if (!*follows) return hole_from(place.offset, reason);
  position_ = place.end();
  return Hole{place.offset, place.end() - place.offset, reason};
}

/// Whether a record can begin at `offset`, by its own content alone.
Result<RecordScanner::Candidate> RecordScanner::look(std::uint64_t offset) {
  if (!has_head(offset)) return Candidate{.reason = "the file ends in the middle of a record"};
  const auto record_head = head(offset);
  if (!record_head) return record_head.error();
  const RecordPlace place{record_head->opcode, offset, record_head->content_bytes};
  if (place.opcode == 0) return Candidate{.reason = "no record stands here"};
  if (place.content_bytes > end_ - offset - kRecordHeadBytes) {
    return Candidate{.reason = "the file ends in the middle of a " + mcap::name_of(place.opcode) +
                               " record, or the length of that is wrong"};
  }
  if (place.content_bytes > options_.max_record_bytes) {
    return Candidate{.reason = "the record is larger than this program reads at once"};
  }
  if (place.opcode == static_cast<std::uint8_t>(Opcode::chunk)) return look_at_chunk(place);
  if (place.opcode == static_cast<std::uint8_t>(Opcode::attachment)) return look_at_attachment(place);
  return look_at_small(place);
}

/// How many bytes of content the chunk's own fields fill; nothing when they do not fit.
Result<std::optional<std::uint64_t>> RecordScanner::filled_by_chunk(const RecordPlace& place) {
  if (place.content_bytes < kChunkFixedBytes) return std::optional<std::uint64_t>{};
  const auto front = probe_.bytes(place.content_offset(), kChunkFixedBytes);
  if (!front) return front.error();
  const auto name_bytes = number_at<std::uint32_t>(*front, 28);
  if (name_bytes > place.content_bytes - kChunkFixedBytes) return std::optional<std::uint64_t>{};
  const auto length = probe_.bytes(place.content_offset() + 32 + name_bytes, 8);
  if (!length) return length.error();
  const auto records = number_at<std::uint64_t>(*length, 0);
  if (records > place.content_bytes - kChunkFixedBytes - name_bytes) return std::optional<std::uint64_t>{};
  return std::optional(kChunkFixedBytes + name_bytes + records);
}

Result<RecordScanner::Candidate> RecordScanner::look_at_chunk(const RecordPlace& place) {
  const auto filled = filled_by_chunk(place);
  if (!filled) return filled.error();
  if (!*filled) return Candidate{.reason = "the chunk's fields do not fit together"};
  return shorten(place, **filled);
}

/// A record that ends earlier than its length says may be of a newer MCAP, or its length is wrong and others stand within.
Result<RecordScanner::Candidate> RecordScanner::shorten(const RecordPlace& place, std::uint64_t filled_bytes) {
  const std::uint64_t filled_end = place.content_offset() + filled_bytes;
  if (filled_end == place.end()) return Candidate{.is_record = true, .end = place.end()};
  const auto inner = find_sure(filled_end, place.end());
  if (!inner) return inner.error();
  return Candidate{.is_record = true, .end = *inner ? filled_end : place.end()};
}

Result<RecordScanner::Candidate> RecordScanner::look_at_attachment(const RecordPlace& place) {
  const auto content = probe_.bytes(place.content_offset(), place.content_bytes);
  if (!content) return content.error();
  const auto record = mcap::decode(place.opcode, *content);
  if (!record) return Candidate{.reason = record.error().message};
  const auto& attachment = std::get<mcap::Attachment>(*record);
  return shorten(place, kAttachmentFixedBytes + attachment.name.size() + attachment.media_type.size() + attachment.data.size());
}

Result<RecordScanner::Candidate> RecordScanner::look_at_small(const RecordPlace& place) {
  const bool is_message = place.opcode == static_cast<std::uint8_t>(Opcode::message);
  if (is_message && place.content_bytes < mcap::kMessageHeadBytes - kRecordHeadBytes) {
    return Candidate{.reason = "the message is too short"};
  }
  // These two end the file's parts: one that is not exactly so is another record with a damaged opcode.
  constexpr std::uint64_t kDataEndBytes = 4;
  constexpr std::uint64_t kFooterBytes = 20;
  const bool is_data_end = place.opcode == static_cast<std::uint8_t>(Opcode::data_end);
  const bool is_footer = place.opcode == static_cast<std::uint8_t>(Opcode::footer);
  if ((is_data_end && place.content_bytes != kDataEndBytes) || (is_footer && place.content_bytes != kFooterBytes)) {
    return Candidate{.reason = "the " + mcap::name_of(place.opcode) + " record has a wrong length"};
  }
  const bool has_layout = place.opcode <= static_cast<std::uint8_t>(Opcode::data_end) && !is_message;
  if (!has_layout || place.content_bytes > kMostSmallBytes) return look_behind(place);
  const auto content = probe_.bytes(place.content_offset(), place.content_bytes);
  if (!content) return content.error();
  const auto record = mcap::decode(place.opcode, *content);
  if (!record) return Candidate{.reason = record.error().message};
  return shorten(place, filled_bytes(*record));
}

/// A record that may hold anything: its length is right when another follows, or when there is none within.
Result<RecordScanner::Candidate> RecordScanner::look_behind(const RecordPlace& place) {
  const auto follows = head_is_plausible(place.end());
  if (!follows) return follows.error();
  if (*follows) return Candidate{.is_record = true, .end = place.end()};
  const auto inner = find_sure(place.offset + 1, place.end());
  if (!inner) return inner.error();
  if (*inner) return Candidate{.reason = "the length of the " + mcap::name_of(place.opcode) + " record is wrong"};
  return Candidate{.is_record = true, .end = place.end()};
}

/// A record may begin there, whole or cut off by the end of the file; or the file ends there.
Result<bool> RecordScanner::head_is_plausible(std::uint64_t offset) {
  if (offset == end_) return true;
  if (end_ - offset < kRecordHeadBytes) return true;  // a torn head
  const auto record_head = head(offset);
  if (!record_head) return record_head.error();
  if (!is_known(record_head->opcode)) return false;
  const bool fits = record_head->content_bytes <= end_ - offset - kRecordHeadBytes;
  const bool torn = record_head->content_bytes <= options_.max_chunk_bytes;
  return fits || torn;
}

/// A chunk whose record length or opcode is wrong still says its length once more inside, and its CRC proves it.
Result<std::optional<RecordPlace>> RecordScanner::mend_chunk(std::uint64_t offset) {
  if (end_ - offset < kRecordHeadBytes + kChunkFixedBytes + kMostCompressionName) return std::optional<RecordPlace>{};
  const auto front = probe_.bytes(offset + kRecordHeadBytes, kChunkFixedBytes + kMostCompressionName);
  if (!front) return front.error();
  const auto name_bytes = number_at<std::uint32_t>(*front, 28);
  const auto crc = number_at<std::uint32_t>(*front, 24);
  if (name_bytes > kMostCompressionName || crc == 0) return std::optional<RecordPlace>{};
  const auto records = number_at<std::uint64_t>(*front, 32 + name_bytes);
  const std::uint64_t before = kChunkFixedBytes + name_bytes;
  if (records == 0 || records > options_.max_record_bytes - before || records > end_ - offset - kRecordHeadBytes - before)
    return std::optional<RecordPlace>{};
  const RecordPlace place{static_cast<std::uint8_t>(Opcode::chunk), offset, before + records};
  const auto matches = crc_matches(place);
  if (!matches) return matches.error();
  return *matches ? std::optional(place) : std::optional<RecordPlace>{};
}

/// Of a chunk or an attachment. One that has no CRC does not match.
Result<bool> RecordScanner::crc_matches(const RecordPlace& place) {
  if (place.content_bytes > std::min(search_budget_bytes_, options_.max_record_bytes)) return false;
  search_budget_bytes_ -= place.content_bytes;
  const auto content = probe_.bytes(place.content_offset(), place.content_bytes);
  if (!content) return content.error();
  const auto record = mcap::decode(place.opcode, *content);
  if (!record) return false;
  if (const auto* chunk = std::get_if<mcap::Chunk>(&*record)) {
    return chunk->uncompressed_crc != 0 && mcap::chunk_records(*chunk, decompressed_, options_).has_value();
  }
  if (const auto* attachment = std::get_if<mcap::Attachment>(&*record)) {
    return attachment->crc != 0 && mcap::check_attachment_crc(*attachment, *content).has_value();
  }
  return false;
}

/// From here on records follow one another: to a chunk, to the footer, or through several small ones.
Result<bool> RecordScanner::chain_holds(std::uint64_t offset) {
  for (int i = 0; i < kChainLength; ++i) {
    if (offset == end_) return i > 1;
    if (!has_head(offset)) return false;
    const auto record_head = head(offset);
    if (!record_head) return record_head.error();
    const RecordPlace place{record_head->opcode, offset, record_head->content_bytes};
    if (place.content_bytes > end_ - offset - kRecordHeadBytes) return false;
    if (place.opcode == static_cast<std::uint8_t>(Opcode::footer)) {
      return place.content_bytes == 20 && end_ - place.end() >= mcap::kMagic.size();
    }
    if (place.opcode == static_cast<std::uint8_t>(Opcode::chunk)) {
      const auto filled = filled_by_chunk(place);
      if (!filled) return filled.error();
      return *filled == place.content_bytes;
    }
    const auto exact = is_exact(place);
    if (!exact || !*exact) return exact;
    offset = place.end();
  }
  return true;
}

/// A small record whose fields fill it.
Result<bool> RecordScanner::is_exact(const RecordPlace& place) {
  if (!is_known(place.opcode) || place.content_bytes == 0) return false;
  if (place.opcode == static_cast<std::uint8_t>(Opcode::message) && !expects_messages_) return false;
  if (place.content_bytes > std::min(kMostSmallBytes, search_budget_bytes_)) return false;
  search_budget_bytes_ -= place.content_bytes;
  const auto content = probe_.bytes(place.content_offset(), place.content_bytes);
  if (!content) return content.error();
  const bool is_private = place.opcode >= static_cast<std::uint8_t>(Opcode::first_private);
  // Roseau's own private records are laid out like metadata; others could be anything.
  const auto opcode = is_private ? static_cast<std::uint8_t>(Opcode::metadata) : place.opcode;
  const auto record = mcap::decode(opcode, *content);
  return record && filled_bytes(*record) == place.content_bytes;
}

Result<bool> RecordScanner::is_sure(std::uint64_t offset) {
  const auto record_head = head(offset);
  if (!record_head) return record_head.error();
  const RecordPlace place{record_head->opcode, offset, record_head->content_bytes};
  if (place.content_bytes > end_ - offset - kRecordHeadBytes) return false;
  if (place.opcode == static_cast<std::uint8_t>(Opcode::chunk)) {
    const auto filled = filled_by_chunk(place);
    if (!filled) return filled.error();
    return *filled == place.content_bytes ? crc_matches(place) : Result<bool>(false);
  }
  if (place.opcode == static_cast<std::uint8_t>(Opcode::attachment)) return crc_matches(place);
  return chain_holds(offset);
}

/// The first place in [from, limit) where a record surely begins.
Result<std::optional<std::uint64_t>> RecordScanner::find_sure(std::uint64_t from, std::uint64_t limit) {
  while (from < limit && has_head(from)) {
    const std::uint64_t size = std::min(kSearchWindowBytes, end_ - from);
    window_.resize(size);
    if (auto read = in_.read(from, window_); !read) return read.error();
    const std::span<const std::byte> window(window_);
    const std::uint64_t starts = std::min(limit - from, size - kRecordHeadBytes + 1);
    for (std::uint64_t i = 0; i < starts; ++i) {
      if (window[i] == std::byte{0} || !is_known(static_cast<std::uint8_t>(window[i]))) continue;
      const auto length = number_at<std::uint64_t>(window, i + 1);
      if (length == 0 || length > end_ - from - i - kRecordHeadBytes) continue;
      if (search_budget_bytes_ == 0) return std::optional<std::uint64_t>{};
      --search_budget_bytes_;
      const auto sure = is_sure(from + i);
      if (!sure) return sure.error();
      if (*sure) return std::optional(from + i);
    }
    from += starts;
  }
  return std::optional<std::uint64_t>{};
}

}  // namespace roseau::recorder
