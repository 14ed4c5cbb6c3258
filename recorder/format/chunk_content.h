// What the records of one chunk are, without their payloads: enough to index the chunk anew when it is copied to another file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "core/result.h"
#include "recorder/format/records.h"

namespace roseau::mcap {

struct ChunkContent {
  struct MessageEntry {
    std::uint16_t channel_id = 0;
    std::uint32_t sequence = 0;
    std::uint64_t log_time_ns = 0;
    std::uint64_t offset = 0;  // of the message record in the uncompressed records
  };
  std::vector<Schema> schemas;
  std::vector<Channel> channels;
  std::vector<MessageEntry> messages;  // in the order of the records
  std::uint64_t start_time_ns = 0;     // of the messages; 0 when there is none
  std::uint64_t end_time_ns = 0;

  /// What does not belong into a chunk, or cannot be read: where, and what it is. The entries before it are good, and those
  /// behind it too when only that one record was wrong.
  std::optional<Error> fault;

  std::map<std::uint16_t, MessageIndex> indexes() const;
};

/// `records` as chunk_records gives them.
ChunkContent chunk_content(std::span<const std::byte> records);

}  // namespace roseau::mcap
