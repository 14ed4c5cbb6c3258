// A small session file that holds every kind of record, and what each of its bytes belongs to: for flipping bits.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/check.h"
#include "recorder/format/codec.h"
#include "recorder/format/topics.h"
#include "recorder/format/writer.h"
#include "tests/support/memory_file.h"

namespace roseau::testing {

struct Region {
  std::string name;
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
};

struct EveryRecord {
  std::vector<std::byte> bytes;
  std::vector<Region> regions;  // in order, without holes
  static constexpr std::uint64_t kMessages = 9;
};

/// What stands where. `bytes` must be a whole file.
inline std::vector<Region> regions_of(std::span<const std::byte> bytes) {
  std::vector<Region> regions = {{"opening magic", 0, mcap::kMagic.size()}};
  bool in_summary = false;
  for (std::uint64_t at = mcap::kMagic.size(); at < bytes.size() - mcap::kMagic.size();) {
    const auto head = mcap::decode_head(bytes.subspan(at));
    const std::uint64_t end = at + mcap::kRecordHeadBytes + head.content_bytes;
    const std::string name =
        mcap::name_of(head.opcode) + (in_summary && (head.opcode == 3 || head.opcode == 4) ? " (repeated)" : "");
    if (const auto record = mcap::decode(head.opcode, bytes.subspan(at + mcap::kRecordHeadBytes, head.content_bytes));
        record && std::holds_alternative<mcap::Chunk>(*record)) {
      const auto& chunk = std::get<mcap::Chunk>(*record);
      const std::uint64_t records = end - chunk.records.size();
      regions.push_back({"chunk, its head", at, records});
      regions.push_back(
          {"chunk, its records (" + (chunk.compression.empty() ? "stored" : chunk.compression) + ")", records, end});
    } else {
      regions.push_back({name, at, end});
    }
    in_summary = in_summary || head.opcode == static_cast<std::uint8_t>(mcap::Opcode::data_end);
    at = end;
  }
  regions.push_back({"closing magic", bytes.size() - mcap::kMagic.size(), bytes.size()});
  return regions;
}

inline EveryRecord every_record() {
  MemoryWritable out;
  mcap::Writer writer(out);
  const auto bytes_of = [](std::string_view text) { return std::as_bytes(std::span(text)); };
  const std::string config = "rate_hz = 20";
  bool good = writer.begin({"x-roseau", "test"}).has_value();
  good = good && writer.write(mcap::to_metadata(mcap::SessionInfo{.schema_version = 1, .program_version = "1"}));
  good =
      good && writer.write(mcap::Attachment{.name = "config.toml", .media_type = "application/toml", .data = bytes_of(config)});
  good = good && writer.write(mcap::Schema{1, "wind", "jsonschema", "{}"});
  good = good && writer.write(mcap::Channel{1, 1, "/wind", "json", {{"unit", "mps"}}});
  std::uint32_t sequence = 0;
  for (const auto compression : {mcap::Compression::none, mcap::Compression::zstd, mcap::Compression::lz4}) {
    mcap::ChunkBuilder chunk(compression);
    for (int i = 0; i < 3; ++i, ++sequence) {
      const std::string text = R"({"u_mps": 1.5, "v_mps": 1.5, "w_mps": 1.5, "n": )" + std::to_string(sequence) + "}";
      chunk.add(mcap::Message{1, sequence, 1000 + sequence, 1000, bytes_of(text)});
    }
    good = good && writer.write(chunk);
    good = good && writer.write_private(
                       mcap::kCheckpointOpcode,
                       mcap::to_metadata(mcap::TopicCounters{{"/wind", {.received = sequence, .recorded = sequence}}}));
  }
  good = good && writer.write(mcap::to_metadata(mcap::TopicCounters{{"/wind", {.received = sequence, .recorded = sequence}}}));
  good = good && writer.finish();
  ROSEAU_CHECK(good && sequence == EveryRecord::kMessages);
  EveryRecord file{std::move(out.bytes), {}};
  file.regions = regions_of(file.bytes);
  return file;
}

}  // namespace roseau::testing
