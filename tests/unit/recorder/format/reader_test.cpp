// What the conformance vectors do not cover: several chunks, compression, overlap, seeking, unknown records.
#include "recorder/format/indexed_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "recorder/format/crc32.h"
#include "recorder/format/stream_reader.h"
#include "recorder/format/writer.h"
#include "tests/support/memory_file.h"

namespace roseau::mcap {
namespace {

using ::testing::ElementsAre;

/// Writes files message by message: the data of each is its sequence number.
class Session {
 public:
  explicit Session(int channels, WriterOptions options = {}) : writer_(out_, options) {
    EXPECT_TRUE(writer_.begin({}));
    for (int id = 1; id <= channels; ++id) {
      EXPECT_TRUE(writer_.write(Channel{static_cast<std::uint16_t>(id), 0, "/topic" + std::to_string(id), "", {}}));
    }
  }
  /// (channel, log time) of each message.
  void chunk(Compression compression, const std::vector<std::pair<std::uint16_t, std::uint64_t>>& messages) {
    ChunkBuilder chunk(compression);
    for (const auto& [channel, time_ns] : messages) chunk.add(next(channel, time_ns));
    EXPECT_TRUE(writer_.write(chunk));
  }
  void loose(std::uint16_t channel, std::uint64_t time_ns) { EXPECT_TRUE(writer_.write(next(channel, time_ns))); }
  Writer& writer() { return writer_; }
  std::unique_ptr<IndexedReader> finish() {
    EXPECT_TRUE(writer_.finish());
    auto reader = IndexedReader::open(std::make_unique<testing::MemoryReadable>(out_.bytes));
    EXPECT_TRUE(reader);
    EXPECT_TRUE((*reader)->index().complete);
    return std::move(*reader);
  }
  const std::vector<std::byte>& bytes() const { return out_.bytes; }

 private:
  Message next(std::uint16_t channel, std::uint64_t time_ns) {
    ++sequence_;
    data_ = std::to_string(sequence_);
    return {channel, sequence_, time_ns, time_ns + 1, std::as_bytes(std::span(data_))};
  }
  testing::MemoryWritable out_;
  Writer writer_;
  std::uint32_t sequence_ = 0;
  std::string data_;
};

std::vector<std::uint64_t> times(IndexedReader& reader, MessageQuery query = {}) {
  std::vector<std::uint64_t> times;
  auto cursor = reader.messages(std::move(query));
  while (true) {
    const auto message = cursor.next();
    EXPECT_TRUE(message) << message.error().message;
    if (!message || !*message) return times;
    const auto data = (*message)->message.data;
    EXPECT_EQ(std::string(reinterpret_cast<const char*>(data.data()), data.size()),
              std::to_string((*message)->message.sequence));
    EXPECT_EQ((*message)->channel->topic, "/topic" + std::to_string((*message)->message.channel_id));
    times.push_back((*message)->message.log_time_ns);
  }
}

class Compressed : public ::testing::TestWithParam<Compression> {};
INSTANTIATE_TEST_SUITE_P(Reader, Compressed, ::testing::Values(Compression::none, Compression::zstd, Compression::lz4));

TEST_P(Compressed, OverlappingChunksAreMergedInOrderOfTime) {
  Session session(2);
  session.chunk(GetParam(), {{1, 10}, {2, 30}, {1, 20}});  // not in order inside a chunk
  session.chunk(GetParam(), {{1, 25}, {2, 5}, {2, 40}});
  session.chunk(GetParam(), {{1, 41}});
  session.chunk(GetParam(), {{2, 1}, {1, 100}});
  const auto reader = session.finish();
  EXPECT_THAT(times(*reader), ElementsAre(1, 5, 10, 20, 25, 30, 40, 41, 100));
  EXPECT_THAT(times(*reader, {.channels = {{2}}}), ElementsAre(1, 5, 30, 40));
  EXPECT_THAT(times(*reader, {.start_time_ns = 20, .end_time_ns = 40}), ElementsAre(20, 25, 30, 40));
  EXPECT_THAT(times(*reader, {.channels = {{1}}, .start_time_ns = 21, .end_time_ns = 99}), ElementsAre(25, 41));
}

TEST(Reader, CompressionReallyCompressesAndIsUndoneOnlyWhenItHelps) {
  for (const auto compression : {Compression::zstd, Compression::lz4}) {
    testing::MemoryWritable out;
    Writer writer(out);
    ASSERT_TRUE(writer.begin({}));
    ASSERT_TRUE(writer.write(Channel{1, 0, "/topic1", "", {}}));
    ChunkBuilder chunk(compression);
    const std::vector<std::byte> zeros(10'000);
    chunk.add(Message{.channel_id = 1, .data = zeros});
    ASSERT_TRUE(writer.write(chunk));
    EXPECT_LT(writer.bytes_written(), 500U);

    chunk.clear();
    std::mt19937 random(1);
    std::vector<std::byte> noise(10'000);
    for (std::byte& byte : noise) byte = static_cast<std::byte>(random());
    chunk.add(Message{.channel_id = 1, .log_time_ns = 1, .data = noise});
    ASSERT_TRUE(writer.write(chunk));
    ASSERT_TRUE(writer.finish());
    const std::string_view text(reinterpret_cast<const char*>(out.bytes.data()), out.bytes.size());
    EXPECT_NE(text.find(std::string_view(reinterpret_cast<const char*>(noise.data()), noise.size())), std::string_view::npos);
    testing::MemoryReadable file(out.bytes);
    StreamReader reader(file);
    std::vector<std::size_t> sizes;
    while (true) {
      const auto record = reader.next();
      ASSERT_TRUE(record) << record.error().message;
      if (!*record) break;
      if (const auto* message = std::get_if<Message>(&**record)) sizes.push_back(message->data.size());
    }
    EXPECT_THAT(sizes, ElementsAre(10'000, 10'000));
    EXPECT_TRUE(reader.complete());
  }
}

TEST(Reader, EqualTimesKeepTheOrderOfTheFile) {
  Session session(1);
  session.chunk(Compression::none, {{1, 7}, {1, 7}});
  session.chunk(Compression::zstd, {{1, 7}});
  session.chunk(Compression::none, {{1, 6}, {1, 7}});
  const auto reader = session.finish();
  auto cursor = reader->messages();
  std::vector<std::uint32_t> sequences;
  while (const auto message = *cursor.next()) sequences.push_back(message->message.sequence);
  EXPECT_THAT(sequences, ElementsAre(4, 1, 2, 3, 5));
}

TEST(Reader, MessagesOutsideOfChunksAreMergedWithThoseInside) {
  Session session(2);
  session.loose(1, 5);
  session.loose(2, 50);
  session.chunk(Compression::none, {{1, 10}, {2, 60}});
  session.loose(1, 40);
  const auto reader = session.finish();
  EXPECT_THAT(times(*reader), ElementsAre(5, 10, 40, 50, 60));
  EXPECT_EQ(reader->index().statistics.message_count, 5U);
}

TEST(Reader, BorrowedPixelsAreWrittenFromWhereTheyAre) {
  testing::MemoryWritable out;
  Writer writer(out);
  ASSERT_TRUE(writer.begin({}));
  ASSERT_TRUE(writer.write(Channel{1, 0, "/topic1", "", {}}));
  const std::vector<std::byte> head(3, std::byte{1});
  std::vector<std::byte> pixels(5000, std::byte{2});
  ChunkBuilder chunk;
  chunk.add(Message{.channel_id = 1, .data = head}, pixels);
  chunk.add(Message{.channel_id = 1, .log_time_ns = 1, .data = head});
  chunk.add(Message{.channel_id = 1, .log_time_ns = 2, .data = head}, pixels);
  pixels[4999] = std::byte{3};  // seen only if the pixels were not copied
  ASSERT_TRUE(writer.write(chunk));
  ASSERT_TRUE(writer.finish());
  auto reader = IndexedReader::open(std::make_unique<testing::MemoryReadable>(out.bytes));
  ASSERT_TRUE(reader);
  auto cursor = (*reader)->messages();
  std::vector<std::size_t> sizes;
  while (const auto message = *cursor.next()) {
    sizes.push_back(message->message.data.size());
    EXPECT_EQ(message->message.data.back(), sizes.back() > 3 ? std::byte{3} : std::byte{1});
  }
  EXPECT_THAT(sizes, ElementsAre(5003, 3, 5003));
}

TEST(Reader, ManyRandomChunksGiveEveryMessageOnceInOrder) {
  std::mt19937 random(3);
  Session session(3);
  std::vector<std::uint64_t> expected;
  for (int c = 0; c < 200; ++c) {
    std::vector<std::pair<std::uint16_t, std::uint64_t>> messages;
    const auto count = random() % 20;
    for (unsigned i = 0; i < count; ++i) {
      messages.emplace_back(static_cast<std::uint16_t>(1 + random() % 3), static_cast<std::uint64_t>(c) * 10 + random() % 60);
      expected.push_back(messages.back().second);
    }
    session.chunk(random() % 2 == 0 ? Compression::none : Compression::zstd, messages);
  }
  std::ranges::sort(expected);
  const auto reader = session.finish();
  EXPECT_EQ(times(*reader), expected);
}

TEST(Reader, UnknownRecordsAreSkippedEverywhere) {
  Session session(1);
  ASSERT_TRUE(session.writer().write_private(static_cast<Opcode>(0x9A), {"anything", {{"a", "b"}}}));
  session.chunk(Compression::none, {{1, 1}});
  const auto reader = session.finish();
  EXPECT_THAT(times(*reader), ElementsAre(1));
  testing::MemoryReadable file(session.bytes());
  StreamReader stream(file);
  int others = 0;
  while (true) {
    const auto record = stream.next();
    ASSERT_TRUE(record);
    if (!*record) break;
    others += std::holds_alternative<OtherRecord>(**record) ? 1 : 0;
  }
  EXPECT_EQ(others, 1);
  EXPECT_TRUE(stream.complete());
}

TEST(Reader, AttachmentsAndMetadataAreFoundByName) {
  Session session(1);
  const std::string config = "rate_hz = 20";
  ASSERT_TRUE(session.writer().write(Attachment{5, 6, "config.toml", "application/toml", std::as_bytes(std::span(config))}));
  ASSERT_TRUE(session.writer().write(Metadata{"roseau", {{"key", "value"}}}));
  session.chunk(Compression::none, {{1, 1}});
  const auto reader = session.finish();
  ASSERT_EQ(reader->index().attachments.size(), 1U);
  std::vector<std::byte> buffer;
  const auto attachment = reader->read(reader->index().attachments[0], buffer);
  ASSERT_TRUE(attachment);
  EXPECT_EQ(attachment->name, "config.toml");
  EXPECT_EQ(attachment->create_time_ns, 6U);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(attachment->data.data()), attachment->data.size()), config);
  EXPECT_EQ(reader->find_metadata("roseau")->value().metadata.at("key"), "value");
  EXPECT_FALSE(reader->find_metadata("nothing")->has_value());
}

class CountingReadable : public testing::MemoryReadable {
 public:
  CountingReadable(std::vector<std::byte> bytes, std::uint64_t& bytes_read)
      : MemoryReadable(std::move(bytes)), bytes_read_(bytes_read) {}
  Result<void> read(std::uint64_t offset, std::span<std::byte> to) override {
    bytes_read_ += to.size();
    return MemoryReadable::read(offset, to);
  }

 private:
  std::uint64_t& bytes_read_;
};

TEST(Reader, AWholeFileIsOpenedFromItsSummaryAlone) {
  Session session(1);
  for (std::uint64_t c = 0; c < 20; ++c) {
    session.chunk(Compression::none, std::vector<std::pair<std::uint16_t, std::uint64_t>>(5000, {1, c}));
  }
  ASSERT_TRUE(session.writer().finish());
  std::uint64_t bytes_read = 0;
  auto reader = IndexedReader::open(std::make_unique<CountingReadable>(session.bytes(), bytes_read));
  ASSERT_TRUE(reader);
  EXPECT_EQ((*reader)->index().statistics.message_count, 100'000U);
  EXPECT_LT(bytes_read, 200'000U);
  EXPECT_GT(session.bytes().size(), 4'000'000U);
}

TEST(Reader, OnlyChunksWithWantedChannelsAreRead) {
  Session session(2);
  session.chunk(Compression::none, {{1, 1}});
  session.chunk(Compression::none, {{2, 2}});
  EXPECT_TRUE(session.writer().finish());
  auto broken = session.bytes();
  const std::string_view text(reinterpret_cast<const char*>(broken.data()), broken.size());
  // Break the first chunk: a query for channel 2 must not even look at it.
  const auto chunk_at = text.find(static_cast<char>(Opcode::chunk), text.find("/topic2"));
  broken[chunk_at + 60] ^= std::byte{1};
  auto reader = IndexedReader::open(std::make_unique<testing::MemoryReadable>(broken));
  ASSERT_TRUE(reader);
  EXPECT_THAT(times(**reader, {.channels = {{2}}}), ElementsAre(2));
  auto all = (*reader)->messages();
  EXPECT_FALSE(all.next());                                              // says that the first chunk is bad
  EXPECT_EQ(all.next()->value().message.log_time_ns, std::uint64_t{2});  // and goes on
}

TEST(Crc32, OfAWholeFromItsParts) {
  const std::string text = "The quick brown fox jumps over the lazy dog";
  const auto bytes = std::as_bytes(std::span(text));
  EXPECT_EQ(crc32(0, bytes), 0x414FA339U);
  for (std::size_t at = 0; at <= bytes.size(); ++at) {
    const auto first = crc32(0, bytes.first(at));
    EXPECT_EQ(crc32(first, bytes.subspan(at)), 0x414FA339U);
    EXPECT_EQ(crc32_combine(first, crc32(0, bytes.subspan(at)), bytes.size() - at), 0x414FA339U);
  }
  EXPECT_EQ(crc32(5, {}), 5U);
}

}  // namespace
}  // namespace roseau::mcap
