// What a session file holds, message by message, for tests that ask what a crash has left of it.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "core/stream.h"
#include "recorder/format/indexed_reader.h"
#include "recorder/format/topics.h"

namespace roseau::testing {

struct StreamFacts {
  StreamRole role = StreamRole::raw;
  std::string kind;
  std::uint64_t messages = 0;
  std::uint64_t missing = 0;  // holes in the numbering
  std::uint32_t last_sequence = 0;
  HostTime last_log_time;
};

struct SessionFacts {
  std::map<std::string, StreamFacts> streams;
  std::optional<mcap::TopicCounters> counters;  // the last checkpoint's
  std::optional<HostTime> first_log_time;
  HostTime last_log_time;
  bool complete = false;
};

inline void count(const mcap::ReadMessage& read, SessionFacts& facts) {
  auto& stream = facts.streams[read.channel->topic];
  if (stream.messages++ == 0) {
    stream.kind = read.channel->metadata.at("roseau.kind");
    const std::string& role = read.channel->metadata.at("roseau.role");
    stream.role = role == "raw" ? StreamRole::raw : role == "derived" ? StreamRole::derived : StreamRole::health;
  } else if (read.message.sequence > stream.last_sequence + 1) {
    stream.missing += read.message.sequence - stream.last_sequence - 1;
  }
  stream.last_sequence = read.message.sequence;
  stream.last_log_time = mcap::host_time_from(read.message.log_time_ns);
  if (!facts.first_log_time) facts.first_log_time = stream.last_log_time;
  facts.last_log_time = stream.last_log_time;
}

inline SessionFacts read_session_facts(const std::filesystem::path& path) {
  SessionFacts facts;
  auto reader = mcap::IndexedReader::open(path);
  if (!reader) {
    ADD_FAILURE() << reader.error().message;
    return facts;
  }
  facts.complete = (*reader)->index().complete;
  auto messages = (*reader)->messages();
  while (true) {
    const auto read = messages.next();
    if (!read) {
      ADD_FAILURE() << read.error().message;
      continue;
    }
    if (!*read) break;
    count(**read, facts);
  }
  for (const auto& record : (*reader)->index().private_records) {
    const auto metadata = (*reader)->read(record);
    if (!metadata) continue;
    if (auto counters = mcap::counters_from(*metadata)) facts.counters = std::move(*counters);
  }
  return facts;
}

}  // namespace roseau::testing
