// Files that are cut, changed or lie: everything that can be read is read, everything that is wrong is said, nothing crashes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "recorder/format/codec.h"
#include "recorder/format/compression.h"
#include "recorder/format/writer.h"
#include "tests/support/exercise_mcap.h"

namespace roseau::mcap {
namespace {

using ::testing::HasSubstr;

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

constexpr std::uint64_t kMessagesPerChunk = 5;
constexpr std::uint64_t kChunks = 3;

/// Three chunks (as they are, zstd, lz4), an attachment, a metadata and a private record.
std::vector<std::byte> sample_file(std::vector<std::uint64_t>* chunk_ends = nullptr) {
  testing::MemoryWritable out;
  Writer writer(out);
  EXPECT_TRUE(writer.begin({"", "test"}));
  const auto config = bytes_of("rate_hz = 20");
  EXPECT_TRUE(writer.write(Attachment{.name = "config.toml", .media_type = "application/toml", .data = config}));
  EXPECT_TRUE(writer.write(Metadata{"roseau", {{"schema_version", "1"}}}));
  EXPECT_TRUE(writer.write(Schema{1, "roseau.Wind", "protobuf", "descriptors"}));
  EXPECT_TRUE(writer.write(Channel{1, 1, "/sonic/wind", "protobuf", {{"roseau.kind", "wind"}}}));
  EXPECT_TRUE(writer.write(Channel{2, 0, "/other", "json", {}}));
  std::uint64_t time_ns = 100;
  for (const auto compression : {Compression::none, Compression::zstd, Compression::lz4}) {
    ChunkBuilder chunk(compression);
    for (std::uint64_t i = 0; i < kMessagesPerChunk; ++i) {
      const auto data = bytes_of(std::string(200, static_cast<char>('a' + i)));
      chunk.add(Message{static_cast<std::uint16_t>(1 + i % 2), static_cast<std::uint32_t>(i), time_ns, time_ns, data});
      ++time_ns;
    }
    EXPECT_TRUE(writer.write(chunk));
    if (chunk_ends != nullptr) {
      std::uint64_t indexes = 0;  // the chunk itself ends before its message indexes
      for (const auto& [id, index] : chunk.indexes()) indexes += 9 + 2 + 4 + 16 * index.entries.size();
      chunk_ends->push_back(out.bytes.size() - indexes);
    }
    EXPECT_TRUE(writer.write_private(kCheckpointOpcode, to_metadata(TopicCounters{{"/sonic/wind", {.received = time_ns}}})));
  }
  EXPECT_TRUE(writer.finish());
  return out.bytes;
}

std::vector<std::byte> cut_at(const std::vector<std::byte>& file, std::size_t size) {
  return {file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size)};
}

TEST(BrokenFile, TheSampleFileItselfIsWhole) {
  const auto content = testing::exercise_mcap(sample_file());
  EXPECT_EQ(content.streamed_messages, kChunks * kMessagesPerChunk);
  EXPECT_EQ(content.indexed_messages, kChunks * kMessagesPerChunk);
  EXPECT_EQ(content.errors, 0U);
}

TEST(BrokenFile, CutAtAnyByteItReadsUpToTheLastWholeChunk) {
  std::vector<std::uint64_t> chunk_ends;
  const auto file = sample_file(&chunk_ends);
  for (std::size_t size = kMagic.size(); size < file.size(); ++size) {
    const auto whole_chunks =
        static_cast<std::uint64_t>(std::ranges::count_if(chunk_ends, [&](auto end) { return end <= size; }));
    const auto content = testing::exercise_mcap(cut_at(file, size));
    EXPECT_EQ(content.streamed_messages, whole_chunks * kMessagesPerChunk) << "cut at " << size;
    EXPECT_EQ(content.indexed_messages, whole_chunks * kMessagesPerChunk) << "cut at " << size;
    EXPECT_GE(content.errors, 1U) << "cut at " << size << " goes unnoticed";
  }
}

TEST(BrokenFile, CutFileSaysWhereAndKeepsItsLastCheckpoint) {
  std::vector<std::uint64_t> chunk_ends;
  const auto file = sample_file(&chunk_ends);
  auto reader = IndexedReader::open(std::make_unique<testing::MemoryReadable>(cut_at(file, chunk_ends[2] - 1)));
  ASSERT_TRUE(reader);
  EXPECT_FALSE((*reader)->index().complete);
  EXPECT_THAT((*reader)->index().damage.at(0), HasSubstr("in the middle of a chunk record that begins at byte"));
  ASSERT_EQ((*reader)->index().private_records.size(), 2U);
  const auto checkpoint = (*reader)->read((*reader)->index().private_records.back());
  ASSERT_TRUE(checkpoint);
  EXPECT_EQ(counters_from(*checkpoint)->at("/sonic/wind").received, 110U);
}

TEST(BrokenFile, EveryChangedBitIsNoticed) {
  const auto file = sample_file();
  for (std::size_t at = 0; at < file.size(); ++at) {
    auto changed = file;
    changed[at] ^= std::byte{0x10};
    testing::MemoryReadable readable(changed);
    StreamReader reader(readable);
    bool noticed = false;
    while (reader.can_continue()) {
      const auto record = reader.next();
      noticed = noticed || !record;
      if (record && !*record) break;
    }
    EXPECT_TRUE(noticed || !reader.complete()) << "byte " << at << " of " << file.size();
  }
}

TEST(BrokenFile, OneBadChunkCostsOnlyItself) {
  std::vector<std::uint64_t> chunk_ends;
  auto file = sample_file(&chunk_ends);
  file[chunk_ends[0] - 3] ^= std::byte{1};
  const auto content = testing::exercise_mcap(file);
  EXPECT_EQ(content.streamed_messages, (kChunks - 1) * kMessagesPerChunk);
  EXPECT_EQ(content.indexed_messages, (kChunks - 1) * kMessagesPerChunk);
  EXPECT_GE(content.errors, 2U);
}

TEST(BrokenFile, MutatedFilesDoNotCrashAnyReader) {
  const auto file = sample_file();
  std::mt19937 random(20);
  for (int round = 0; round < 1000; ++round) {
    auto mutated = file;
    const auto changes = 1 + random() % 4;
    for (unsigned i = 0; i < changes; ++i) mutated[random() % mutated.size()] = static_cast<std::byte>(random());
    if (random() % 3 == 0) mutated.resize(random() % mutated.size());
    if (random() % 5 == 0)
      mutated.insert(mutated.begin() + static_cast<std::ptrdiff_t>(random() % (mutated.size() + 1)), 7, std::byte{6});
    static_cast<void>(testing::exercise_mcap(mutated));
  }
}

Error opening_error(std::vector<std::byte> file) {
  auto reader = IndexedReader::open(std::make_unique<testing::MemoryReadable>(std::move(file)));
  return reader ? Error{ErrorCode::io, "it opened"} : reader.error();
}

TEST(BrokenFile, OtherFilesAreRefusedWithTheReason) {
  EXPECT_THAT(opening_error({}).message, HasSubstr("empty"));
  EXPECT_THAT(opening_error(bytes_of("RIFF....AVI LIST")).message, HasSubstr("not an MCAP file"));
  auto newer = sample_file();
  newer[5] = std::byte{'1'};
  EXPECT_EQ(opening_error(newer).code, ErrorCode::unsupported);
  EXPECT_THAT(opening_error(newer).message, HasSubstr("major version '1'"));
}

/// A file whose only chunk is this record.
std::vector<std::byte> file_with(const Chunk& chunk) {
  std::vector<std::byte> file(kMagic.begin(), kMagic.end());
  encode(Header{}, file);
  encode_chunk_head(chunk, chunk.records.size(), file);
  file.insert(file.end(), chunk.records.begin(), chunk.records.end());
  return file;
}

std::string damage_of(std::vector<std::byte> file) {
  auto reader = IndexedReader::open(std::make_unique<testing::MemoryReadable>(std::move(file)));
  return reader && !(*reader)->index().damage.empty() ? (*reader)->index().damage.back() : "none";
}

TEST(BrokenFile, SizesInTheFileAreNotBelieved) {
  const std::vector<std::byte> zeros(100'000);
  std::vector<std::byte> small;
  ASSERT_TRUE(compress(Compression::zstd, zeros, small));
  for (const char* compression : {"zstd", "lz4", ""}) {
    const Chunk lies{.uncompressed_size = std::uint64_t{1} << 60U, .compression = compression, .records = small};
    EXPECT_THAT(damage_of(file_with(lies)), HasSubstr("announces")) << compression;
  }
  for (const std::uint64_t size : {std::uint64_t{99'999}, std::uint64_t{100'001}, std::uint64_t{1} << 30U, std::uint64_t{0}}) {
    const Chunk lies{.uncompressed_size = size, .compression = "zstd", .records = small};
    EXPECT_THAT(damage_of(file_with(lies)), HasSubstr("bytes it announces")) << size;
  }
  std::vector<std::byte> huge_record(kMagic.begin(), kMagic.end());
  huge_record.push_back(std::byte{0x0C});
  huge_record.insert(huge_record.end(), 8, std::byte{0xFF});
  EXPECT_THAT(damage_of(huge_record), HasSubstr("in the middle of a metadata record"));
}

TEST(BrokenFile, UnknownCompressionIsNamed) {
  const Chunk chunk{.uncompressed_size = 3, .compression = "snappy", .records = {}};
  EXPECT_THAT(damage_of(file_with(chunk)), HasSubstr("'snappy'"));
}

TEST(BrokenFile, ZeroesAfterAPowerCutAreTheEnd) {
  std::vector<std::uint64_t> chunk_ends;
  auto file = sample_file(&chunk_ends);
  file.resize(chunk_ends[1]);
  file.resize(file.size() + 4096);
  const auto content = testing::exercise_mcap(file);
  EXPECT_EQ(content.streamed_messages, 2 * kMessagesPerChunk);
  EXPECT_EQ(content.indexed_messages, 2 * kMessagesPerChunk);
}

}  // namespace
}  // namespace roseau::mcap
