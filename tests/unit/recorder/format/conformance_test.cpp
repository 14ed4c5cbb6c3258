// The official MCAP conformance vectors: every one read in file order, those with an index read through it, and every one
// without padding written again, byte for byte.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "recorder/format/indexed_reader.h"
#include "recorder/format/stream_reader.h"
#include "recorder/format/writer.h"
#include "tests/support/data.h"
#include "tests/support/memory_file.h"

namespace roseau::mcap {
namespace {

using Json = nlohmann::json;
using Path = std::filesystem::path;

std::vector<std::byte> read_file(const Path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::vector<Path> vectors(const Path& root) {
  std::vector<Path> paths;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root)) {
    if (entry.path().extension() == ".mcap") paths.push_back(entry.path());
  }
  std::ranges::sort(paths);
  return paths;
}

struct Expected {
  Json records;
  std::set<std::string> features;
};

Expected expected_of(Path path) {
  std::ifstream file(path.replace_extension(".json"));
  const Json json = Json::parse(file);
  return {json["records"], json["meta"]["variant"]["features"].get<std::set<std::string>>()};
}

// ---------------------------------------------------------------------------------------------------------------------
// Records as the vectors spell them

template <class T>
  requires std::is_integral_v<T>
Json spell(T value) {
  return std::to_string(value);
}
Json spell(Opcode value) { return std::to_string(static_cast<int>(value)); }
Json spell(const StringMap& value) { return Json(value); }
Json spell(const std::map<std::uint16_t, std::uint64_t>& value) {
  Json map = Json::object();
  for (const auto& [key, number] : value) map[std::to_string(key)] = std::to_string(number);
  return map;
}
Json spell_bytes(std::span<const std::byte> bytes) {
  Json array = Json::array();
  for (const std::byte byte : bytes) array.push_back(std::to_string(static_cast<int>(byte)));
  return array;
}

Json as_json(const char* type, const Json& fields_by_name) {
  Json fields = Json::array();
  for (const auto& [name, value] : fields_by_name.items()) fields.push_back({name, value});  // sorted by name
  return {{"type", type}, {"fields", fields}};
}

Json as_json(const Header& r) { return as_json("Header", {{"profile", r.profile}, {"library", r.library}}); }
Json as_json(const Footer& r) {
  return as_json("Footer", {{"summary_start", spell(r.summary_start)},
                            {"summary_offset_start", spell(r.summary_offset_start)},
                            {"summary_crc", spell(r.summary_crc)}});
}
Json as_json(const Schema& r) {
  return as_json("Schema", {{"id", spell(r.id)},
                            {"name", r.name},
                            {"encoding", r.encoding},
                            {"data", spell_bytes(std::as_bytes(std::span(r.data)))}});
}
Json as_json(const Channel& r) {
  return as_json("Channel", {{"id", spell(r.id)},
                             {"schema_id", spell(r.schema_id)},
                             {"topic", r.topic},
                             {"message_encoding", r.message_encoding},
                             {"metadata", spell(r.metadata)}});
}
Json as_json(const Message& r) {
  return as_json("Message", {{"channel_id", spell(r.channel_id)},
                             {"sequence", spell(r.sequence)},
                             {"log_time", spell(r.log_time_ns)},
                             {"publish_time", spell(r.publish_time_ns)},
                             {"data", spell_bytes(r.data)}});
}
Json as_json(const ChunkIndex& r) {
  return as_json("ChunkIndex", {{"message_start_time", spell(r.start_time_ns)},
                                {"message_end_time", spell(r.end_time_ns)},
                                {"chunk_start_offset", spell(r.chunk_offset)},
                                {"chunk_length", spell(r.chunk_length)},
                                {"message_index_offsets", spell(r.message_index_offsets)},
                                {"message_index_length", spell(r.message_index_length)},
                                {"compression", r.compression},
                                {"compressed_size", spell(r.compressed_size)},
                                {"uncompressed_size", spell(r.uncompressed_size)}});
}
Json as_json(const Attachment& r) {
  return as_json("Attachment", {{"log_time", spell(r.log_time_ns)},
                                {"create_time", spell(r.create_time_ns)},
                                {"name", r.name},
                                {"media_type", r.media_type},
                                {"data", spell_bytes(r.data)}});
}
Json as_json(const AttachmentIndex& r) {
  return as_json("AttachmentIndex", {{"offset", spell(r.offset)},
                                     {"length", spell(r.length)},
                                     {"log_time", spell(r.log_time_ns)},
                                     {"create_time", spell(r.create_time_ns)},
                                     {"data_size", spell(r.data_size)},
                                     {"name", r.name},
                                     {"media_type", r.media_type}});
}
Json as_json(const Statistics& r) {
  return as_json("Statistics", {{"message_count", spell(r.message_count)},
                                {"schema_count", spell(r.schema_count)},
                                {"channel_count", spell(r.channel_count)},
                                {"attachment_count", spell(r.attachment_count)},
                                {"metadata_count", spell(r.metadata_count)},
                                {"chunk_count", spell(r.chunk_count)},
                                {"message_start_time", spell(r.message_start_time_ns)},
                                {"message_end_time", spell(r.message_end_time_ns)},
                                {"channel_message_counts", spell(r.channel_message_counts)}});
}
Json as_json(const Metadata& r) { return as_json("Metadata", {{"name", r.name}, {"metadata", spell(r.metadata)}}); }
Json as_json(const MetadataIndex& r) {
  return as_json("MetadataIndex", {{"offset", spell(r.offset)}, {"length", spell(r.length)}, {"name", r.name}});
}
Json as_json(const SummaryOffset& r) {
  return as_json(
      "SummaryOffset",
      {{"group_opcode", spell(r.group)}, {"group_start", spell(r.group_start)}, {"group_length", spell(r.group_length)}});
}
Json as_json(const DataEnd& r) { return as_json("DataEnd", {{"data_section_crc", spell(r.data_section_crc)}}); }
Json as_json(const Chunk&) { return "never handed out"; }
Json as_json(const MessageIndex&) { return "never handed out"; }
Json as_json(const OtherRecord&) { return "none in the vectors"; }

Json as_json(const Record& record) {
  return std::visit([](const auto& known) { return as_json(known); }, record);
}

// ---------------------------------------------------------------------------------------------------------------------
// The vectors' records as ours

class Fields {
 public:
  explicit Fields(const Json& record) {
    for (const auto& field : record["fields"]) values_[field[0]] = field[1];
  }
  std::string text(const char* name) const { return values_.at(name); }
  StringMap map(const char* name) const { return values_.at(name); }
  template <class T>
  T number(const char* name) const {
    return static_cast<T>(std::stoull(values_.at(name).get<std::string>()));
  }
  std::vector<std::byte> bytes(const char* name) const {
    std::vector<std::byte> bytes;
    for (const auto& byte : values_.at(name)) bytes.push_back(static_cast<std::byte>(std::stoi(byte.get<std::string>())));
    return bytes;
  }

 private:
  std::map<std::string, Json> values_;
};

Schema schema_from(const Fields& fields) {
  const auto data = fields.bytes("data");
  return {fields.number<std::uint16_t>("id"), fields.text("name"), fields.text("encoding"),
          std::string(reinterpret_cast<const char*>(data.data()), data.size())};
}

Channel channel_from(const Fields& fields) {
  return {fields.number<std::uint16_t>("id"), fields.number<std::uint16_t>("schema_id"), fields.text("topic"),
          fields.text("message_encoding"), fields.map("metadata")};
}

std::vector<std::byte> write_again(const Expected& expected) {
  const auto has = [&](const char* feature) { return expected.features.contains(feature); };
  testing::MemoryWritable out;
  Writer writer(out, {.message_indexes = has("mx"),
                      .statistics = has("st"),
                      .repeat_schemas = has("rsh"),
                      .repeat_channels = has("rch"),
                      .attachment_indexes = has("ax"),
                      .metadata_indexes = has("mdx"),
                      .chunk_indexes = has("chx"),
                      .summary_offsets = has("sum")});
  const bool chunked = has("ch");
  ChunkBuilder chunk;
  const auto write = [&](const auto& record) {
    if (!chunked) return writer.write(record);
    chunk.add(record);
    return Result<void>{};
  };
  EXPECT_TRUE(writer.begin({}));
  for (const auto& record : expected.records) {
    const Fields fields(record);
    const std::string type = record["type"];
    if (type == "DataEnd") break;
    if (type == "Schema") {
      EXPECT_TRUE(write(schema_from(fields)));
    }
    if (type == "Channel") {
      EXPECT_TRUE(write(channel_from(fields)));
    }
    if (type == "Message") {
      const auto data = fields.bytes("data");
      EXPECT_TRUE(write(Message{fields.number<std::uint16_t>("channel_id"), fields.number<std::uint32_t>("sequence"),
                                fields.number<std::uint64_t>("log_time"), fields.number<std::uint64_t>("publish_time"), data}));
    }
    if (type == "Attachment") {
      const auto data = fields.bytes("data");
      EXPECT_TRUE(writer.write(Attachment{fields.number<std::uint64_t>("log_time"), fields.number<std::uint64_t>("create_time"),
                                          fields.text("name"), fields.text("media_type"), data}));
    }
    if (type == "Metadata") {
      EXPECT_TRUE(writer.write(Metadata{fields.text("name"), fields.map("metadata")}));
    }
  }
  EXPECT_TRUE(writer.write(chunk));
  EXPECT_TRUE(writer.finish());
  return out.bytes;
}

// ---------------------------------------------------------------------------------------------------------------------

TEST(Conformance, EveryVectorIsReadInFileOrder) {
  ROSEAU_REQUIRE_DATA(root, "mcap_conformance");
  const auto paths = vectors(root);
  EXPECT_EQ(paths.size(), 416U);
  for (const Path& path : paths) {
    testing::MemoryReadable file(read_file(path));
    StreamReader reader(file);
    Json records = Json::array();
    while (true) {
      const auto record = reader.next();
      ASSERT_TRUE(record) << path << ": " << record.error().message;
      if (!*record) break;
      records.push_back(as_json(**record));
    }
    EXPECT_TRUE(reader.complete()) << path << ": " << reader.ending();
    EXPECT_EQ(records, expected_of(path).records) << path;
  }
}

TEST(Conformance, MessagesAreReadInOrderOfTimeWithOrWithoutAnIndex) {
  ROSEAU_REQUIRE_DATA(root, "mcap_conformance");
  int with_full_index = 0;
  for (const Path& path : vectors(root)) {
    const Expected expected = expected_of(path);
    const auto has = [&](const char* feature) { return expected.features.contains(feature); };
    auto reader = IndexedReader::open(std::make_unique<testing::MemoryReadable>(read_file(path)));
    ASSERT_TRUE(reader) << path << ": " << reader.error().message;
    EXPECT_TRUE((*reader)->index().complete) << path;

    std::vector<Json> messages;
    Json statistics;
    for (const auto& record : expected.records) {
      if (record["type"] == "Message") messages.push_back(record);
      if (record["type"] == "Statistics") statistics = record;
    }
    std::ranges::stable_sort(messages, {}, [](const Json& record) { return Fields(record).number<std::uint64_t>("log_time"); });
    std::vector<Json> read;
    auto cursor = (*reader)->messages();
    while (true) {
      const auto message = cursor.next();
      ASSERT_TRUE(message) << path << ": " << message.error().message;
      if (!*message) break;
      read.push_back(as_json((*message)->message));
    }
    EXPECT_EQ(read, messages) << path;
    if (!statistics.is_null()) {
      EXPECT_EQ(as_json((*reader)->index().statistics), statistics) << path;
    }
    with_full_index += !messages.empty() && has("ch") && has("chx") && has("mx") && has("rch") && has("rsh") ? 1 : 0;
  }
  EXPECT_EQ(with_full_index, 16);
}

TEST(Conformance, EveryVectorWithoutPaddingIsWrittenByteForByte) {
  ROSEAU_REQUIRE_DATA(root, "mcap_conformance");
  int written = 0;
  for (const Path& path : vectors(root)) {
    const Expected expected = expected_of(path);
    if (expected.features.contains("pad")) continue;
    const auto ours = write_again(expected);
    const auto theirs = read_file(path);
    const auto differ = std::ranges::mismatch(ours, theirs);
    EXPECT_TRUE(ours == theirs) << path << " differs at byte " << differ.in1 - ours.begin() << " of " << theirs.size();
    ++written;
  }
  EXPECT_EQ(written, 208);
}

}  // namespace
}  // namespace roseau::mcap
