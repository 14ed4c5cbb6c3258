// Reads whatever bytes these are with every reader there is: used by the fuzzer, and by a test over broken files.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "recorder/format/indexed_reader.h"
#include "recorder/format/stream_reader.h"
#include "recorder/format/topics.h"
#include "tests/support/memory_file.h"

namespace roseau::testing {

struct McapContent {
  std::uint64_t streamed_messages = 0;
  std::uint64_t indexed_messages = 0;
  std::uint64_t errors = 0;
};

inline McapContent exercise_mcap(std::span<const std::byte> bytes) {
  McapContent content;
  const mcap::ReaderOptions options{.max_chunk_bytes = 1U << 24U};  // keeps a fuzzer's memory small
  MemoryReadable file({bytes.begin(), bytes.end()});
  mcap::StreamReader stream(file, options);
  while (true) {
    const auto record = stream.next();
    if (!record) ++content.errors;
    if (record && !*record) break;
    if (!record && !stream.can_continue()) break;
    if (record && std::holds_alternative<mcap::Message>(**record)) ++content.streamed_messages;
  }
  auto reader = mcap::IndexedReader::open(std::make_unique<MemoryReadable>(std::vector(bytes.begin(), bytes.end())), options);
  if (!reader) {
    ++content.errors;
    return content;
  }
  const mcap::FileIndex& index = (*reader)->index();
  content.errors += index.damage.size();
  auto cursor = (*reader)->messages();
  while (true) {
    const auto message = cursor.next();
    if (!message) ++content.errors;
    if (message && !*message) break;
    if (message) ++content.indexed_messages;
  }
  for (const auto& [id, channel] : (*reader)->catalog().channels()) {
    static_cast<void>(mcap::stream_info_from(channel, (*reader)->catalog().schema_of(channel)).has_value());
  }
  std::vector<std::byte> buffer;
  for (const auto& entry : index.attachments) content.errors += (*reader)->read(entry, buffer) ? 0U : 1U;
  for (const auto& entry : index.metadata) content.errors += (*reader)->read(entry) ? 0U : 1U;
  for (const auto& entry : index.private_records) {
    const auto metadata = (*reader)->read(entry);
    if (metadata) static_cast<void>(mcap::counters_from(*metadata).has_value());
  }
  return content;
}

}  // namespace roseau::testing
