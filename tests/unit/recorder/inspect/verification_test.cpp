// Verification: every bit that changed is noticed, and what is wrong is named.
#include "recorder/tools/inspect/verification.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "recorder/format/codec.h"
#include "schema/conversion.h"
#include "tests/support/every_record.h"
#include "tests/support/samples.h"

namespace roseau::recorder {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;
using Bytes = std::vector<std::byte>;

Bytes bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

Result<Verification> verify(const Bytes& file) {
  testing::MemoryReadable in(file);
  return verify_session(in);
}

TEST(Verification, AWholeFileHasNoProblems) {
  const auto file = testing::every_record();
  const auto found = verify(file.bytes);
  ASSERT_TRUE(found);
  EXPECT_THAT(found->problems, IsEmpty());
  EXPECT_THAT(found->remarks, IsEmpty());
  EXPECT_TRUE(found->is_complete);
  EXPECT_EQ(found->messages, testing::EveryRecord::kMessages);
  EXPECT_EQ(found->chunks, 3U);
  EXPECT_EQ(found->attachments, 1U);
  EXPECT_EQ(found->crcs_checked, 6U);  // three chunks, the attachment, the data section, the summary
  ASSERT_EQ(found->streams.size(), 1U);
  EXPECT_EQ(found->streams[0].payloads_checked, testing::EveryRecord::kMessages);
}

TEST(Verification, TheTestFileHoldsEveryKindOfRecord) {
  std::set<std::string> names;
  const auto file = testing::every_record();
  std::uint64_t at = 0;
  for (const auto& region : file.regions) {
    EXPECT_EQ(region.begin, at);
    at = region.end;
    names.insert(region.name);
  }
  EXPECT_EQ(at, file.bytes.size());
  for (const char* name : {"header",
                           "footer",
                           "schema",
                           "channel",
                           "chunk, its head",
                           "chunk, its records (stored)",
                           "chunk, its records (zstd)",
                           "chunk, its records (lz4)",
                           "message index",
                           "chunk index",
                           "attachment",
                           "attachment index",
                           "statistics",
                           "metadata",
                           "metadata index",
                           "summary offset",
                           "data end",
                           "record 0x80",
                           "schema (repeated)",
                           "channel (repeated)"}) {
    EXPECT_TRUE(names.contains(name)) << name;
  }
}

TEST(Verification, EverySingleBitFlipIsNoticed) {
  const auto file = testing::every_record();
  for (const auto& region : file.regions) {
    for (std::uint64_t bit = 8 * region.begin; bit < 8 * region.end; ++bit) {
      auto damaged = file.bytes;
      damaged[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
      const auto found = verify(damaged);
      EXPECT_TRUE(!found || found->problem_count > 0) << region.name << ", bit " << bit - 8 * region.begin;
    }
  }
}

TEST(Verification, EveryCutIsNoticed) {
  const auto file = testing::every_record();
  for (std::size_t size = 0; size < file.bytes.size(); ++size) {
    const auto found = verify({file.bytes.begin(), file.bytes.begin() + static_cast<std::ptrdiff_t>(size)});
    EXPECT_TRUE(!found || (found->problem_count > 0 && !found->is_complete)) << size;
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// Files whose checksums are right or absent, and that lie all the same

struct Raw {
  std::uint8_t opcode = 0;
  Bytes content;
};

std::vector<Raw> records_of(std::span<const std::byte> file) {
  std::vector<Raw> records;
  for (std::uint64_t at = mcap::kMagic.size(); at < file.size() - mcap::kMagic.size();) {
    const auto head = mcap::decode_head(file.subspan(at));
    const auto content = file.subspan(at + mcap::kRecordHeadBytes, head.content_bytes);
    records.push_back({head.opcode, {content.begin(), content.end()}});
    at += mcap::kRecordHeadBytes + head.content_bytes;
  }
  return records;
}

/// The file of these records, with the CRCs of data section and summary left out.
Bytes file_of(const std::vector<Raw>& records) {
  Bytes file(mcap::kMagic.begin(), mcap::kMagic.end());
  for (const auto& [opcode, content] : records) {
    auto record = mcap::decode(opcode, content);
    if (record && std::holds_alternative<mcap::DataEnd>(*record)) {
      encode(mcap::DataEnd{}, file);
    } else if (record && std::holds_alternative<mcap::Footer>(*record)) {
      auto footer = std::get<mcap::Footer>(*record);
      footer.summary_crc = 0;
      encode(footer, file);
    } else {
      encode(mcap::OtherRecord{opcode, content}, file);
    }
  }
  file.insert(file.end(), mcap::kMagic.begin(), mcap::kMagic.end());
  return file;
}

/// The test file with the n-th record of type T changed; its size must stay.
template <class T>
Bytes changed(const std::function<void(T&)>& change, std::size_t number = 0) {
  auto records = records_of(testing::every_record().bytes);
  for (auto& [opcode, content] : records) {
    auto record = mcap::decode(opcode, content);
    if (!record || !std::holds_alternative<T>(*record)) continue;
    if (number-- > 0) continue;
    Bytes encoded;
    if constexpr (std::is_same_v<T, mcap::Chunk>) {
      auto& chunk = std::get<T>(*record);
      change(chunk);
      encode_chunk_head(chunk, chunk.records.size(), encoded);
      encoded.insert(encoded.end(), chunk.records.begin(), chunk.records.end());
    } else {
      change(std::get<T>(*record));
      encode(std::get<T>(*record), encoded);
    }
    encoded.erase(encoded.begin(), encoded.begin() + mcap::kRecordHeadBytes);
    content = encoded;
    return file_of(records);
  }
  ADD_FAILURE() << "no such record";
  return {};
}

std::vector<std::string> problems_of(const Bytes& file) {
  const auto found = verify(file);
  EXPECT_TRUE(found);
  return found ? found->problems : std::vector<std::string>{};
}

TEST(Verification, WithoutChecksumsThatIsSaid) {
  const auto found = verify(file_of(records_of(testing::every_record().bytes)));
  ASSERT_TRUE(found);
  EXPECT_THAT(found->problems, IsEmpty());
  EXPECT_THAT(found->remarks,
              UnorderedElementsAre(HasSubstr("no CRC of its data section"), HasSubstr("no CRC of its summary")));
}

TEST(Verification, CountsAreComparedWithTheContent) {
  const auto statistics = [](auto change) { return problems_of(changed<mcap::Statistics>(change)); };
  EXPECT_THAT(statistics([](auto& s) { ++s.message_count; }), ElementsAre(HasSubstr("counts 10 messages, the file holds 9")));
  EXPECT_THAT(statistics([](auto& s) { ++s.schema_count; }), ElementsAre(HasSubstr("2 schemas")));
  EXPECT_THAT(statistics([](auto& s) { ++s.channel_count; }), ElementsAre(HasSubstr("2 channels")));
  EXPECT_THAT(statistics([](auto& s) { s.attachment_count = 0; }), ElementsAre(HasSubstr("0 attachments")));
  EXPECT_THAT(statistics([](auto& s) { ++s.metadata_count; }), ElementsAre(HasSubstr("metadata records")));
  EXPECT_THAT(statistics([](auto& s) { ++s.chunk_count; }), ElementsAre(HasSubstr("4 chunks")));
  EXPECT_THAT(statistics([](auto& s) { ++s.message_end_time_ns; }), ElementsAre(HasSubstr("log times")));
  EXPECT_THAT(statistics([](auto& s) { s.channel_message_counts[1] = 8; }),
              ElementsAre(HasSubstr("/wind: the summary counts 8")));
  EXPECT_THAT(statistics([](auto& s) {
                s.channel_message_counts = {{9, 9}};
              }),
              UnorderedElementsAre(HasSubstr("/wind: the summary counts 0"), HasSubstr("channel 9: the summary counts 9")));
}

TEST(Verification, IndexesAreComparedWithWhatTheyPointTo) {
  const auto chunk = [](auto change) { return problems_of(changed<mcap::ChunkIndex>(change, 1)); };
  EXPECT_THAT(chunk([](auto& i) { ++i.chunk_offset; }), Contains(HasSubstr("points to where no chunk begins")));
  EXPECT_THAT(chunk([](auto& i) { ++i.chunk_length; }), ElementsAre(HasSubstr("other sizes")));
  EXPECT_THAT(chunk([](auto& i) { --i.uncompressed_size; }), ElementsAre(HasSubstr("other sizes")));
  EXPECT_THAT(chunk([](auto& i) { ++i.start_time_ns; }), ElementsAre(HasSubstr("other times")));
  EXPECT_THAT(chunk([](auto& i) { ++i.message_index_offsets[1]; }), ElementsAre(HasSubstr("message indexes")));
  EXPECT_THAT(chunk([](auto& i) { ++i.message_index_length; }), ElementsAre(HasSubstr("message indexes")));
  const auto message = [](auto change) { return problems_of(changed<mcap::MessageIndex>(change, 2)); };
  EXPECT_THAT(message([](auto& i) { ++i.entries[1].first; }), ElementsAre(HasSubstr("does not fit what its chunk holds")));
  EXPECT_THAT(message([](auto& i) { --i.entries[1].second; }), ElementsAre(HasSubstr("does not fit what its chunk holds")));
  EXPECT_THAT(message([](auto& i) { i.channel_id = 2; }), Contains(HasSubstr("does not fit what its chunk holds")));
  EXPECT_THAT(problems_of(changed<mcap::AttachmentIndex>([](auto& i) { ++i.offset; })),
              ElementsAre(HasSubstr("attachment 'config.toml'")));
  EXPECT_THAT(problems_of(changed<mcap::AttachmentIndex>([](auto& i) { ++i.data_size; })),
              ElementsAre(HasSubstr("attachment 'config.toml'")));
  EXPECT_THAT(problems_of(changed<mcap::MetadataIndex>([](auto& i) { i.name[0] = 'R'; })),
              ElementsAre(HasSubstr("metadata 'Roseau'")));
  EXPECT_THAT(problems_of(changed<mcap::SummaryOffset>([](auto& o) { ++o.group_length; })),
              ElementsAre(HasSubstr("summary offset of the schema")));
  EXPECT_THAT(problems_of(changed<mcap::Footer>([](auto& f) { ++f.summary_start; })),
              ElementsAre(HasSubstr("does not point to the summary")));
  EXPECT_THAT(problems_of(changed<mcap::Footer>([](auto& f) { ++f.summary_offset_start; })),
              ElementsAre(HasSubstr("summary offsets")));
}

TEST(Verification, ChunkTimesAreComparedWithTheMessages) {
  const auto problems = problems_of(changed<mcap::Chunk>([](auto& c) { --c.start_time_ns; }));
  EXPECT_THAT(problems, Contains(HasSubstr("says log times 999 to 1002, its messages have 1000 to 1002")));
}

TEST(Verification, TheSameIdMustMeanTheSame) {
  EXPECT_THAT(problems_of(changed<mcap::Channel>([](auto& c) { c.topic[1] = 'W'; }, 1)),
              Contains(HasSubstr("two different channels have the id 1")));
  EXPECT_THAT(problems_of(changed<mcap::Schema>([](auto& s) { s.data[0] = '['; }, 1)),
              Contains(HasSubstr("two different schemas have the id 1")));
}

TEST(Verification, RecordsInTheWrongPlaceAreNamed) {
  const auto whole = records_of(testing::every_record().bytes);
  const auto with = [&](std::size_t at, std::size_t of) {
    auto records = whole;
    records.insert(records.begin() + static_cast<std::ptrdiff_t>(at), records[of]);
    return problems_of(file_of(records));
  };
  EXPECT_THAT(with(2, 0), Contains(HasSubstr("a second header")));
  const std::size_t footer = whole.size() - 1;
  EXPECT_THAT(with(footer, 2), Contains(HasSubstr("a attachment record behind the end")));
  auto without_header = whole;
  without_header.erase(without_header.begin());
  EXPECT_THAT(problems_of(file_of(without_header)), Contains(HasSubstr("does not begin with a header")));
  auto without_channel = whole;
  without_channel.erase(without_channel.begin() + 4);
  EXPECT_THAT(problems_of(file_of(without_channel)), Contains(HasSubstr("channel 1, which is not described")));
}

TEST(Verification, BytesBehindTheEndAreNamed) {
  auto file = testing::every_record().bytes;
  file.resize(file.size() + 13);
  EXPECT_THAT(problems_of(file), ElementsAre(HasSubstr("13 bytes stand behind the end")));
}

// ---------------------------------------------------------------------------------------------------------------------
// Streams and payloads

/// A file with one channel and these messages.
Bytes file_with(const mcap::Schema& schema, const mcap::Channel& channel,
                const std::vector<std::pair<std::uint32_t, Bytes>>& messages, const mcap::TopicCounters& counters = {}) {
  testing::MemoryWritable out;
  mcap::Writer writer(out);
  EXPECT_TRUE(writer.begin({}));
  EXPECT_TRUE(writer.write(schema));
  EXPECT_TRUE(writer.write(channel));
  mcap::ChunkBuilder chunk;
  std::uint64_t time_ns = 5;
  for (const auto& [sequence, data] : messages) chunk.add(mcap::Message{channel.id, sequence, ++time_ns, 1, data});
  EXPECT_TRUE(writer.write(chunk));
  const bool counted = counters.empty() || writer.write(mcap::to_metadata(counters)).has_value();
  EXPECT_TRUE(counted);
  EXPECT_TRUE(writer.finish());
  return out.bytes;
}

mcap::Channel stream_channel(SampleKind kind) {
  return mcap::make_channel({.topic = "/it", .kind = std::string(to_string(kind)), .device = "d"}, 1, 1);
}

TEST(Verification, EveryKindOfPayloadParses) {
  for (std::size_t i = 0; i < kSampleKindCount; ++i) {
    const auto kind = static_cast<SampleKind>(i);
    StreamTable streams;
    streams.add({.topic = "/it", .kind = std::string(to_string(kind)), .device = "d"});
    FramePool pool(2, 64);
    const Sample sample = testing::filled_sample(kind, streams, pool);
    Bytes message;
    schema::serialize(sample, streams, message);
    if (kind == SampleKind::skip) continue;  // names a stream that this file does not hold
    const auto whole = verify(file_with(mcap::make_schema(kind, 1), stream_channel(kind), {{1, message}}));
    ASSERT_TRUE(whole);
    EXPECT_THAT(whole->problems, IsEmpty()) << to_string(kind);
    EXPECT_EQ(whole->streams.at(0).payloads_checked, 1U);
    message.resize(message.size() - 1);
    EXPECT_THAT(problems_of(file_with(mcap::make_schema(kind, 1), stream_channel(kind), {{1, message}})),
                Contains(HasSubstr("/it, sequence 1")))
        << to_string(kind);
  }
}

TEST(Verification, PayloadsOfOtherProgramsParseAgainstTheSchemaInTheFile) {
  auto schema = mcap::make_schema(SampleKind::wind, 1);
  mcap::Channel channel{1, 1, "/it", "protobuf", {}};
  // A message type that this program knows as text only: the descriptor set is roseau's, the name another message in it.
  schema.name = "roseau.SampleHeader";
  const Bytes good = bytes_of(std::string("\x7a\x01x", 3));  // field 15, which the schema does not know
  EXPECT_THAT(problems_of(file_with(schema, channel, {{1, good}})), IsEmpty());
  const Bytes torn = bytes_of(std::string("\x7a\x05x", 3));
  EXPECT_THAT(problems_of(file_with(schema, channel, {{1, torn}})), ElementsAre(HasSubstr("runs past the end")));
  schema.name = "other.Message";
  EXPECT_THAT(problems_of(file_with(schema, channel, {{1, good}})), ElementsAre(HasSubstr("does not describe other.Message")));
}

TEST(Verification, JsonIsReadAndUnknownEncodingsAreNamed) {
  const mcap::Schema schema{1, "it", "jsonschema", "{}"};
  EXPECT_THAT(problems_of(file_with(schema, {1, 1, "/it", "json", {}}, {{1, bytes_of("{\"a\": 1}")}})), IsEmpty());
  EXPECT_THAT(problems_of(file_with(schema, {1, 1, "/it", "json", {}}, {{1, bytes_of("{\"a\": }")}})),
              ElementsAre(HasSubstr("is not JSON")));
  const auto other = verify(file_with(schema, {1, 1, "/it", "cdr", {}}, {{1, bytes_of("x")}}));
  ASSERT_TRUE(other);
  EXPECT_THAT(other->problems, IsEmpty());
  EXPECT_THAT(other->streams.at(0).unchecked, HasSubstr("'cdr'"));
}

TEST(Verification, HolesInTheNumbersAreNoProblemButSaid) {
  const mcap::Schema schema{1, "it", "jsonschema", "{}"};
  const mcap::Channel channel{1, 1, "/it", "json", {}};
  const Bytes empty = bytes_of("{}");
  const auto found = verify(file_with(schema, channel, {{1, empty}, {2, empty}, {6, empty}, {7, empty}, {8, empty}},
                                      {{"/it", {.recorded = 5, .dropped = 3, .gaps = 1}}}));
  ASSERT_TRUE(found);
  EXPECT_THAT(found->problems, IsEmpty());
  EXPECT_EQ(found->streams.at(0).missing, 3U);
  EXPECT_EQ(found->streams.at(0).jumps, 1U);
  EXPECT_EQ(found->streams.at(0).dropped, 3U);
  EXPECT_EQ(found->streams.at(0).gaps, 1U);
  EXPECT_THAT(to_text(*found), HasSubstr("/it: 3 numbers missing in 1 places (device gaps 1, dropped 3)"));
}

TEST(Verification, TheRecordersOwnCountIsCompared) {
  const mcap::Schema schema{1, "it", "jsonschema", "{}"};
  const auto problems =
      problems_of(file_with(schema, {1, 1, "/it", "json", {}}, {{1, bytes_of("{}")}}, {{"/it", {.recorded = 2}}}));
  EXPECT_THAT(problems, ElementsAre(HasSubstr("/it: the recorder counted 2 messages, the file holds 1")));
}

TEST(Verification, InputsOutOfOrderAreNamed) {
  testing::MemoryWritable out;
  mcap::Writer writer(out);
  ASSERT_TRUE(writer.begin({}));
  ASSERT_TRUE(writer.write(mcap::make_schema(SampleKind::raw_bytes, 1)));
  ASSERT_TRUE(writer.write(stream_channel(SampleKind::raw_bytes)));
  mcap::ChunkBuilder chunk;
  for (const std::uint64_t time_ns : {5U, 6U, 6U, 4U}) chunk.add(mcap::Message{1, 0, time_ns, 1, {}});
  ASSERT_TRUE(writer.write(chunk));
  ASSERT_TRUE(writer.finish());
  EXPECT_THAT(problems_of(out.bytes), Contains(HasSubstr("/it: 2 inputs stand out of order")));
}

TEST(Verification, AChannelWithoutATopicIsNamed) {
  EXPECT_THAT(problems_of(file_with({1, "it", "jsonschema", "{}"}, {1, 1, "", "json", {}}, {{1, bytes_of("{}")}})),
              ElementsAre(HasSubstr("channel 1 has no topic")));
}

}  // namespace
}  // namespace roseau::recorder
