// RecordScanner: the records of a file that may be broken anywhere. Where no record can stand, the scanner looks for the next
// place where one surely does, and says what it passed over.
//
// "Surely" means: a chunk or an attachment whose CRC matches, or a small record whose fields fill it exactly and behind which
// further such records follow. Pixels, zeros and text do not look like that.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/result.h"
#include "recorder/format/chunk_records.h"
#include "recorder/format/io.h"
#include "recorder/format/record_reader.h"

namespace roseau::recorder {

/// Bytes in which no record can be found.
struct Hole {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
  std::string reason;
};

class RecordScanner {
 public:
  using Found = std::variant<mcap::RecordPlace, Hole>;

  RecordScanner(mcap::Readable& in, std::uint64_t offset, const mcap::ReaderOptions& options);

  /// The next record or hole; nothing at the end of the file. An Error only when the file cannot be read.
  Result<std::optional<Found>> next();

  /// Valid until the next call of content, bytes or reject.
  Result<std::span<const std::byte>> content(const mcap::RecordPlace& place) { return records_.content(place); }
  Result<std::span<const std::byte>> bytes(std::uint64_t offset, std::uint64_t size) { return records_.bytes(offset, size); }

  /// This file has messages outside of chunks. Until this is said the search does not take messages for records: those in a
  /// torn or damaged chunk look the same, and its CRC is what they need.
  void expect_messages() { expects_messages_ = true; }

  /// How many records said a wrong length, that others proved wrong.
  std::uint64_t mended_lengths() const { return mended_lengths_; }

  /// The record found last cannot be trusted (its CRC is wrong). The hole that this leaves: the record itself, or more where
  /// its length is wrong too. The scan goes on behind the hole.
  Result<Hole> reject(const mcap::RecordPlace& place, const std::string& reason);

 private:
  struct Candidate {
    bool is_record = false;
    std::uint64_t end = 0;
    std::string reason;  // why it is none
  };

  bool has_head(std::uint64_t offset) const { return offset <= end_ && end_ - offset >= mcap::kRecordHeadBytes; }
  Result<mcap::RecordHead> head(std::uint64_t offset);
  Result<Candidate> look(std::uint64_t offset);
  Result<Candidate> look_at_small(const mcap::RecordPlace& place);
  Result<Candidate> look_at_chunk(const mcap::RecordPlace& place);
  Result<Candidate> look_at_attachment(const mcap::RecordPlace& place);
  Result<Candidate> look_behind(const mcap::RecordPlace& place);
  Result<Candidate> shorten(const mcap::RecordPlace& place, std::uint64_t filled_bytes);
  Result<std::optional<std::uint64_t>> filled_by_chunk(const mcap::RecordPlace& place);
  Result<bool> head_is_plausible(std::uint64_t offset);
  Result<bool> is_sure(std::uint64_t offset);
  Result<bool> crc_matches(const mcap::RecordPlace& place);
  Result<bool> chain_holds(std::uint64_t offset);
  Result<bool> is_exact(const mcap::RecordPlace& place);
  Result<std::optional<std::uint64_t>> find_sure(std::uint64_t from, std::uint64_t limit);
  Result<std::optional<mcap::RecordPlace>> mend_chunk(std::uint64_t offset);
  Result<Hole> hole_from(std::uint64_t offset, std::string reason);

  mcap::Readable& in_;
  mcap::ReaderOptions options_;
  std::uint64_t position_;
  std::uint64_t end_;
  std::uint64_t search_budget_bytes_;  // bounds the work that a file made to be slow can cause
  bool expects_messages_ = false;
  std::uint64_t mended_lengths_ = 0;
  mcap::RecordReader records_;  // what content() gives
  mcap::RecordReader probe_;    // for looking around
  std::vector<std::byte> window_;
  std::vector<std::byte> decompressed_;
};

}  // namespace roseau::recorder
