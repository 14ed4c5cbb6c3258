#include "recorder/tools/inspect/verification.h"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <utility>

#include "recorder/format/catalog.h"
#include "recorder/format/chunk_content.h"
#include "recorder/format/crc32.h"
#include "recorder/format/file_io.h"
#include "recorder/format/record_reader.h"
#include "recorder/format/stream_reader.h"
#include "recorder/format/topics.h"
#include "recorder/tools/inspect/problems.h"
#include "recorder/tools/inspect/stream_check.h"
#include "recorder/tools/inspect/summary_check.h"

namespace roseau::recorder {

namespace {

using mcap::Opcode;
using mcap::RecordPlace;

constexpr std::uint64_t kProgressStep = 1U << 20U;
constexpr std::uint64_t kFooterBytes = 20;

std::uint8_t code(Opcode opcode) { return static_cast<std::uint8_t>(opcode); }

std::array<std::byte, mcap::kRecordHeadBytes> head_bytes(const RecordPlace& place) {
  std::array<std::byte, mcap::kRecordHeadBytes> head{};
  head[0] = static_cast<std::byte>(place.opcode);
  for (std::size_t i = 0; i < 8; ++i) head[1 + i] = static_cast<std::byte>(place.content_bytes >> (8 * i));
  return head;
}

class Verifier {
 public:
  Verifier(mcap::Readable& in, const VerifyOptions& options)
      : in_(in),
        options_(options),
        records_(in, mcap::kMagic.size(), in.size(), options.reader.max_record_bytes),
        streams_(problems_),
        summary_(problems_) {}

  Result<Verification> run() {
    if (auto magic = mcap::check_opening_magic(in_); !magic) return magic.error();
    crc_ = mcap::crc32(0, mcap::kMagic);
    while (!ended_) {
      const auto place = records_.next();
      if (!place && place.error().code == ErrorCode::io) return place.error();
      if (!place) problems_.add(place.error().message);
      if (place && !*place) problems_.add(fmt::format("ends without a footer, at byte {}", records_.position()));
      if (!place || !*place) break;
      if (auto seen = see(**place); !seen) return seen.error();
      if (!go_on((*place)->end())) return Error{ErrorCode::io, "stopped"};
    }
    if (!ended_) summary_.end_chunk();
    return finish();
  }

 private:
  bool go_on(std::uint64_t offset) {
    if (!options_.progress || offset < next_progress_) return true;
    next_progress_ = offset + kProgressStep;
    return options_.progress(static_cast<double>(offset) / static_cast<double>(in_.size()));
  }

  void problem_at(const RecordPlace& place, const std::string& what) {
    problems_.add(fmt::format("at byte {}: {}", place.offset, what));
  }

  /// An Error only when reading fails.
  Result<void> see(const RecordPlace& place) {
    const auto content = records_.content(place);
    if (!content && content.error().code == ErrorCode::unsupported) problem_at(place, content.error().message);
    if (!content) return content.error().code == ErrorCode::unsupported ? Result<void>{} : content.error();
    if (std::exchange(is_first_, false) != (place.opcode == code(Opcode::header))) {
      problem_at(place, place.opcode == code(Opcode::header) ? "a second header record"
                                                             : "the file does not begin with a header record");
    }
    const bool is_end = place.opcode == code(Opcode::data_end) || place.opcode == code(Opcode::footer);
    auto record = mcap::decode(place.opcode, *content);
    const auto* chunk = record ? std::get_if<mcap::Chunk>(&*record) : nullptr;
    if (chunk != nullptr) {
      see_chunk(place, *content, *chunk);
      return {};
    }
    if (!is_end) crc_ = mcap::crc32(mcap::crc32(crc_, head_bytes(place)), *content);
    if (!record) {
      problem_at(place, record.error().message);
      return {};
    }
    if (in_summary_) {
      see_summary(place, *record);
    } else {
      see_data(place, *record, *content);
    }
    return {};
  }

  // ---- the data section

  void see_chunk(const RecordPlace& place, std::span<const std::byte> content, const mcap::Chunk& chunk) {
    if (in_summary_) problem_at(place, "a chunk behind the end of the data section");
    const auto records = mcap::chunk_records(chunk, decompressed_, options_.reader);
    // Bytes stored as they are have been summed already.
    const bool summed = records && chunk.compression.empty() && chunk.uncompressed_crc != 0;
    const auto before = static_cast<std::size_t>(chunk.records.data() - content.data());
    const std::uint32_t stored_crc = summed ? chunk.uncompressed_crc : mcap::crc32(0, chunk.records);
    crc_ = mcap::crc32(mcap::crc32(crc_, head_bytes(place)), content.first(before));
    crc_ = mcap::crc32_combine(crc_, stored_crc, chunk.records.size());
    crc_ = mcap::crc32(crc_, content.subspan(before + chunk.records.size()));
    if (chunk.uncompressed_crc != 0) ++found_.crcs_checked;
    if (chunk.uncompressed_crc == 0) ++chunks_without_crc_;
    if (!records) {
      problem_at(place, records.error().message);
      return summary_.see_chunk(place, chunk, nullptr);
    }
    const auto inside = mcap::chunk_content(*records);
    if (inside.fault) problem_at(place, "the chunk " + inside.fault->message);
    see_records(place, *records);
    summary_.see_chunk(place, chunk, &inside);
  }

  void see_records(const RecordPlace& chunk, std::span<const std::byte> records) {
    std::uint64_t position = 0;
    while (true) {
      const auto place = mcap::next_record(records, position);
      if (!place || !*place) return;  // chunk_content has said so
      const auto record = mcap::decode((*place)->opcode, records.subspan((*place)->content_offset(), (*place)->content_bytes));
      if (!record) continue;
      const bool is_definition =
          std::holds_alternative<mcap::Schema>(*record) || std::holds_alternative<mcap::Channel>(*record);
      if (is_definition) define(chunk, *record);
      if (const auto* message = std::get_if<mcap::Message>(&*record)) streams_.see(*message);
    }
  }

  void define(const RecordPlace& place, const mcap::Record& record) {
    Result<void> added;
    if (const auto* schema = std::get_if<mcap::Schema>(&record)) {
      if (schema->id == 0) problem_at(place, "a schema with the id 0, which no channel can use");
      added = catalog_.add(*schema);
    }
    if (const auto* channel = std::get_if<mcap::Channel>(&record)) {
      added = catalog_.add(*channel);
      if (added) streams_.see(*channel, catalog_.schema_of(*channel));
    }
    if (!added) problem_at(place, added.error().message);
  }

  void see_data(const RecordPlace& place, const mcap::Record& record, std::span<const std::byte> content) {
    if (const auto* index = std::get_if<mcap::MessageIndex>(&record)) return summary_.see_message_index(place, *index);
    summary_.end_chunk();
    summary_.see_other(place, record);
    define(place, record);
    if (const auto* message = std::get_if<mcap::Message>(&record)) streams_.see(*message);
    if (const auto* attachment = std::get_if<mcap::Attachment>(&record)) {
      ++found_.attachments;
      if (attachment->crc != 0) ++found_.crcs_checked;
      if (auto checked = mcap::check_attachment_crc(*attachment, content); !checked) problem_at(place, checked.error().message);
    }
    if (const auto* metadata = std::get_if<mcap::Metadata>(&record)) see_metadata(place, *metadata);
    if (const auto* data_end = std::get_if<mcap::DataEnd>(&record)) see_data_end(place, *data_end);
    if (const auto* footer = std::get_if<mcap::Footer>(&record)) {
      problem_at(place, "the data section has no end record");
      see_footer(place, *footer);
    }
    const bool belongs_behind = place.opcode == code(Opcode::chunk_index) || place.opcode == code(Opcode::statistics) ||
                                place.opcode == code(Opcode::attachment_index) ||
                                place.opcode == code(Opcode::metadata_index) || place.opcode == code(Opcode::summary_offset);
    if (belongs_behind)
      problem_at(place, "a " + mcap::name_of(place.opcode) + " record in front of the end of the data section");
  }

  void see_metadata(const RecordPlace& place, const mcap::Metadata& metadata) {
    if (metadata.name == mcap::kSessionMetadata) {
      if (auto info = mcap::session_info_from(metadata); !info) problem_at(place, info.error().message);
    }
    if (metadata.name != mcap::kCountersMetadata) return;
    const auto counters = mcap::counters_from(metadata);
    if (!counters) return problem_at(place, counters.error().message);
    counters_ = *counters;
  }

  void see_data_end(const RecordPlace& place, const mcap::DataEnd& data_end) {
    if (place.content_bytes != 4) problem_at(place, "the data end record has a wrong length");
    if (data_end.data_section_crc == 0) {
      found_.remarks.emplace_back(
          "the file has no CRC of its data section: a change outside of chunks and attachments cannot be seen");
    } else {
      ++found_.crcs_checked;
      if (data_end.data_section_crc != crc_) {
        problem_at(place, "the data section's CRC does not match: bytes have changed since they were written");
      }
    }
    in_summary_ = true;
    summary_start_ = place.end();
    crc_ = 0;
  }

  // ---- the summary

  void see_summary(const RecordPlace& place, const mcap::Record& record) {
    if (const auto* footer = std::get_if<mcap::Footer>(&record)) return see_footer(place, *footer);
    if (place.opcode == code(Opcode::message) || place.opcode == code(Opcode::attachment) ||
        place.opcode == code(Opcode::metadata) || place.opcode == code(Opcode::data_end) ||
        place.opcode == code(Opcode::message_index)) {
      return problem_at(place, "a " + mcap::name_of(place.opcode) + " record behind the end of the data section");
    }
    if (const auto* channel = std::get_if<mcap::Channel>(&record);
        channel != nullptr && catalog_.channel(channel->id) == nullptr) {
      problem_at(place, "the summary describes " + channel->topic + ", which the data section does not");
    }
    define(place, record);
    summary_.see_summary(place, record);
    if (offsets_start_ == 0 && std::holds_alternative<mcap::SummaryOffset>(record)) offsets_start_ = place.offset;
    summary_end_ = place.end();
  }

  void see_footer(const RecordPlace& place, const mcap::Footer& footer) {
    ended_ = true;
    if (place.content_bytes != kFooterBytes) problem_at(place, "the footer has a wrong length");
    const bool has_summary = in_summary_ && summary_end_ > 0;
    if (footer.summary_start != (has_summary ? summary_start_ : 0))
      problem_at(place, "the footer does not point to the summary");
    if (footer.summary_offset_start != 0 && footer.summary_offset_start != offsets_start_) {
      problem_at(place, "the footer does not point to the summary offsets");
    }
    if (footer.summary_crc != 0) {
      ++found_.crcs_checked;
      if (mcap::crc32(crc_, mcap::footer_prefix(footer)) != footer.summary_crc) {
        problem_at(place, "the summary's CRC does not match: bytes have changed since they were written");
      }
    } else {
      found_.remarks.emplace_back("the file has no CRC of its summary");
    }
    summary_.finish(footer, streams_, catalog_);
    see_ending(place);
  }

  void see_ending(const RecordPlace& footer) {
    std::array<std::byte, mcap::kMagic.size()> magic{};
    const std::uint64_t left = in_.size() - footer.end();
    found_.is_complete = left >= magic.size() && in_.read(footer.end(), magic) && magic == mcap::kMagic;
    if (!found_.is_complete) problems_.add(fmt::format("ends without its closing magic, at byte {}", footer.end()));
    if (left > magic.size()) {
      problems_.add(fmt::format("{} bytes stand behind the end of the file, from byte {} on", left - magic.size(),
                                footer.end() + magic.size()));
    }
  }

  Verification finish() {
    if (counters_) streams_.see(*counters_);
    if (chunks_without_crc_ > 0) found_.remarks.push_back(fmt::format("{} chunks have no CRC", chunks_without_crc_));
    found_.bytes = in_.size();
    found_.messages = streams_.messages();
    found_.chunks = summary_.chunks();
    found_.streams = streams_.finish();
    found_.problem_count = problems_.count();
    found_.problems = problems_.take();
    return std::move(found_);
  }

  mcap::Readable& in_;
  const VerifyOptions& options_;
  mcap::RecordReader records_;
  Problems problems_;
  StreamCheck streams_;
  SummaryCheck summary_;
  mcap::Catalog catalog_;
  Verification found_;
  std::optional<mcap::TopicCounters> counters_;
  std::vector<std::byte> decompressed_;
  bool is_first_ = true;
  bool in_summary_ = false;
  bool ended_ = false;
  std::uint32_t crc_ = 0;  // of the data section, then of the summary, up to here
  std::uint64_t summary_start_ = 0;
  std::uint64_t summary_end_ = 0;
  std::uint64_t offsets_start_ = 0;
  std::uint64_t chunks_without_crc_ = 0;
  std::uint64_t next_progress_ = 0;
};

}  // namespace

Result<Verification> verify_session(mcap::Readable& in, const VerifyOptions& options) { return Verifier(in, options).run(); }

Result<Verification> verify_session(const std::filesystem::path& path, const VerifyOptions& options) {
  auto file = mcap::FileReadable::open(path);
  if (!file) return file.error();
  auto found = verify_session(**file, options);
  if (!found) return found.error().with_context(path.string());
  return found;
}

}  // namespace roseau::recorder
