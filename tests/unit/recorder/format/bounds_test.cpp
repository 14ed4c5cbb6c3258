// What a file can make a reader allocate is bounded (chunk_records.h says how), and odd but legal files read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <new>
#include <random>

#include "recorder/format/codec.h"
#include "recorder/format/compression.h"
#include "recorder/format/file_io.h"
#include "recorder/format/writer.h"
#include "tests/support/every_record.h"
#include "tests/support/exercise_mcap.h"
#include "tests/support/temporary_folder.h"

// Every allocation of this program is counted.
namespace {
std::atomic<std::size_t> held_bytes{0};
std::atomic<std::size_t> most_held_bytes{0};

void* counted(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  const std::size_t now = held_bytes += ::malloc_usable_size(memory);
  std::size_t most = most_held_bytes;
  while (now > most && !most_held_bytes.compare_exchange_weak(most, now)) {
  }
  return memory;
}
void give_back(void* memory) {
  if (memory != nullptr) held_bytes -= ::malloc_usable_size(memory);
  std::free(memory);
}
}  // namespace

void* operator new(std::size_t size) { return counted(std::malloc(size)); }
void* operator new[](std::size_t size) { return counted(std::malloc(size)); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return counted(std::malloc(size)); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return counted(std::malloc(size)); }
void operator delete(void* memory) noexcept { give_back(memory); }
void operator delete[](void* memory) noexcept { give_back(memory); }
void operator delete(void* memory, std::size_t) noexcept { give_back(memory); }
void operator delete[](void* memory, std::size_t) noexcept { give_back(memory); }

namespace roseau::mcap {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using Bytes = std::vector<std::byte>;

constexpr ReaderOptions kSmall{.max_chunk_bytes = 1U << 20U, .max_record_bytes = 2U << 20U, .max_open_bytes = 4U << 20U};

/// Not one byte is copied: what is counted is the readers' own.
class View : public Readable {
 public:
  explicit View(const Bytes& bytes) : bytes_(bytes) {}
  std::uint64_t size() const override { return bytes_.size(); }
  Result<void> read(std::uint64_t offset, std::span<std::byte> to) override {
    std::ranges::copy(std::span(bytes_).subspan(offset, to.size()), to.begin());
    return {};
  }

 private:
  const Bytes& bytes_;
};

struct Cost {
  std::size_t streamed = 0;
  std::size_t indexed = 0;
  std::vector<std::string> errors;
  std::uint64_t messages = 0;  // indexed
};

template <class Work>
std::size_t most_allocated(Work work) {
  const std::size_t before = held_bytes;
  most_held_bytes = before;
  work();
  return most_held_bytes - before;
}

Cost cost_of(const Bytes& file) {
  Cost cost;
  cost.errors.reserve(1000);
  const auto note = [&](const Error& error) {
    if (cost.errors.size() < cost.errors.capacity()) cost.errors.push_back(error.message);
  };
  cost.streamed = most_allocated([&] {
    View in(file);
    StreamReader reader(in, kSmall);
    while (reader.can_continue()) {
      const auto record = reader.next();
      if (!record) note(record.error());
      if (record && !*record) break;
    }
  });
  cost.indexed = most_allocated([&] {
    auto reader = IndexedReader::open(std::make_unique<View>(file), kSmall);
    if (!reader) return note(reader.error());
    for (const auto& damage : (*reader)->index().damage) note({ErrorCode::corrupt, damage});
    auto cursor = (*reader)->messages();
    for (auto message = cursor.next();; message = cursor.next()) {
      if (!message) note(message.error());
      if (message && !*message) break;
      if (message) ++cost.messages;
    }
  });
  return cost;
}

std::size_t streamed_bound(const Bytes& file) {
  return std::min<std::size_t>(file.size(), kSmall.max_record_bytes) + 3 * kSmall.max_chunk_bytes + 32 * file.size() +
         (1U << 20U);
}
std::size_t indexed_bound(const Bytes& file) { return streamed_bound(file) + 3 * kSmall.max_open_bytes; }

/// A chunk of `bytes` zeros in one message, compressed; `announced` is what it says of its size.
void add_bomb(Compression compression, std::uint64_t bytes, std::uint64_t announced, Bytes& file) {
  Bytes records;
  encode_message_head({.channel_id = 1, .log_time_ns = 5}, bytes, records);
  records.resize(records.size() + bytes);
  Bytes small;
  ASSERT_TRUE(compress(compression, records, small));
  const Chunk chunk{.start_time_ns = 5,
                    .end_time_ns = 5,
                    .uncompressed_size = announced == 0 ? records.size() : announced,
                    .compression = std::string(to_string(compression)),
                    .records = small};
  encode_chunk_head(chunk, small.size(), file);
  file.insert(file.end(), small.begin(), small.end());
}

Bytes beginning() {
  Bytes file(kMagic.begin(), kMagic.end());
  encode(Header{}, file);
  encode(Channel{.id = 1, .topic = "/a", .message_encoding = "x"}, file);
  return file;
}

TEST(Bounds, ZipBombsAreRefusedWithoutUnpackingThem) {
  for (const auto compression : {Compression::zstd, Compression::lz4}) {
    // What is announced is above the bound; what is announced is small, and much comes out; much is announced, little comes
    // out.
    const std::pair<std::uint64_t, std::uint64_t> cases[] = {
        {64U << 20U, 0}, {64U << 20U, 1000}, {64U << 20U, 1U << 20U}, {10, 1U << 20U}};
    for (const auto& [bytes, announced] : cases) {
      Bytes file = beginning();
      add_bomb(compression, bytes, announced, file);
      const Cost cost = cost_of(file);
      EXPECT_EQ(cost.messages, 0U);
      ASSERT_FALSE(cost.errors.empty());
      EXPECT_THAT(cost.errors[0], AnyOf(HasSubstr("announces"), HasSubstr("zstd"), HasSubstr("lz4")));
      EXPECT_LE(cost.streamed, streamed_bound(file));
      EXPECT_LE(cost.indexed, indexed_bound(file));
    }
  }
}

TEST(Bounds, ManyChunksAtOneTimeAreNotAllOpenedTogether) {
  Bytes file = beginning();
  constexpr int kChunks = 40;  // 36 MB when all are open
  for (int i = 0; i < kChunks; ++i) add_bomb(Compression::zstd, 900'000, 0, file);
  const Cost cost = cost_of(file);
  EXPECT_LT(cost.messages, std::uint64_t{kChunks});
  EXPECT_GE(cost.messages, 4U);
  EXPECT_THAT(cost.errors, ::testing::Contains(HasSubstr("too many chunks overlap in time")));
  EXPECT_LE(cost.indexed, indexed_bound(file));
}

TEST(Bounds, ARecordTooLargeIsPassedOver) {
  Bytes file = beginning();
  const Bytes large(3U << 20U);
  encode(Attachment{.name = "large", .data = large}, file);
  Bytes records;
  encode(Message{.channel_id = 1, .log_time_ns = 7, .data = {}}, records);
  encode_chunk_head({.start_time_ns = 7, .end_time_ns = 7, .uncompressed_size = records.size()}, records.size(), file);
  file.insert(file.end(), records.begin(), records.end());
  const Cost cost = cost_of(file);
  EXPECT_EQ(cost.messages, 1U);
  EXPECT_THAT(cost.errors, ::testing::Contains(HasSubstr("more than this program reads at once")));
}

/// Any change to any byte, and cuts: never more than the bound.
TEST(Bounds, BrokenFilesStayWithinThem) {
  const auto file = testing::every_record();
  std::mt19937 random(9);
  for (std::size_t round = 0; round < 2 * file.bytes.size(); ++round) {
    auto mutated = file.bytes;
    mutated[round % mutated.size()] ^= static_cast<std::byte>(1 + random() % 255);
    if (round >= mutated.size()) mutated.resize(random() % mutated.size());
    const Cost cost = cost_of(mutated);
    EXPECT_LE(cost.streamed, streamed_bound(mutated)) << round;
    EXPECT_LE(cost.indexed, indexed_bound(mutated)) << round;
  }
}

/// Lengths that say 2^32 and more, at every place where a length stands.
TEST(Bounds, LengthsBeyondTheFileAreNotBelieved) {
  const auto file = testing::every_record();
  for (std::size_t at = kMagic.size(); at + 8 <= file.bytes.size(); ++at) {
    for (const std::size_t width : {4U, 8U}) {
      auto mutated = file.bytes;
      std::fill_n(mutated.begin() + static_cast<std::ptrdiff_t>(at), width, std::byte{0xFF});
      const Cost cost = cost_of(mutated);
      EXPECT_LE(cost.streamed, streamed_bound(mutated)) << at;
      EXPECT_LE(cost.indexed, indexed_bound(mutated)) << at;
    }
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// Odd, and readable

TEST(Bounds, ACutAnywhereInALargeFileReadsUpToIt) {
  testing::MemoryWritable out;
  Writer writer(out);
  ASSERT_TRUE(writer.begin({}));
  ASSERT_TRUE(writer.write(Channel{.id = 1, .topic = "/a", .message_encoding = "x"}));
  std::vector<std::uint64_t> ends;
  std::mt19937 random(5);
  std::uint64_t time_ns = 0;
  for (int c = 0; c < 50; ++c) {
    ChunkBuilder chunk(c % 2 == 0 ? Compression::none : Compression::zstd);
    for (int i = 0; i < 20; ++i) {
      Bytes data(500 + random() % 2000);
      for (auto& byte : data) byte = static_cast<std::byte>(random() % 16);
      chunk.add(Message{1, static_cast<std::uint32_t>(time_ns), time_ns, time_ns, data});
      ++time_ns;
    }
    ASSERT_TRUE(writer.write(chunk));
    ends.push_back(out.bytes.size() - (9 + 2 + 4 + 16 * 20));
  }
  ASSERT_TRUE(writer.finish());
  for (int i = 0; i < 1000; ++i) {
    const std::size_t size = 100 + random() % (out.bytes.size() - 100);
    const auto content = testing::exercise_mcap(std::span(out.bytes).first(size));
    const auto whole = static_cast<std::uint64_t>(std::ranges::count_if(ends, [&](auto end) { return end <= size; }));
    EXPECT_EQ(content.streamed_messages, 20 * whole) << size;
    EXPECT_EQ(content.indexed_messages, 20 * whole) << size;
  }
}

TEST(Bounds, SixtyFiveThousandChannelsRead) {
  constexpr std::uint32_t kChannels = 65'535;
  testing::MemoryWritable out;
  Writer writer(out);
  ASSERT_TRUE(writer.begin({}));
  ASSERT_TRUE(writer.write(Schema{1, "s", "jsonschema", "{}"}));
  ChunkBuilder chunk(Compression::zstd);
  for (std::uint32_t i = 1; i <= kChannels; ++i) {
    const auto id = static_cast<std::uint16_t>(i);
    chunk.add(Channel{id, 1, "/channel/" + std::to_string(i), "json", {}});
    chunk.add(Message{id, 0, i, i, {}});
  }
  ASSERT_TRUE(writer.write(chunk));
  ASSERT_TRUE(writer.finish());
  EXPECT_EQ(writer.statistics().channel_count, kChannels);
  const auto content = testing::exercise_mcap(out.bytes);
  EXPECT_EQ(content.errors, 0U);
  EXPECT_EQ(content.streamed_messages, kChannels);
  EXPECT_EQ(content.indexed_messages, kChannels);
  // And without its summary.
  const auto cut = testing::exercise_mcap(std::span(out.bytes).first(out.bytes.size() - 20));
  EXPECT_EQ(cut.indexed_messages, kChannels);
}

TEST(Bounds, TopicsWithoutANameAndIdsUsedTwice) {
  Bytes file(kMagic.begin(), kMagic.end());
  encode(Header{}, file);
  encode(Channel{.id = 1, .topic = "", .message_encoding = "x"}, file);
  encode(Message{.channel_id = 1, .log_time_ns = 3}, file);
  const auto nameless = testing::exercise_mcap(file);
  EXPECT_EQ(nameless.streamed_messages, 1U);
  EXPECT_EQ(nameless.indexed_messages, 1U);
  encode(Channel{.id = 1, .topic = "/b", .message_encoding = "x"}, file);
  encode(Message{.channel_id = 1, .log_time_ns = 4}, file);
  const Cost cost = cost_of(file);
  EXPECT_THAT(cost.errors, ::testing::Contains(HasSubstr("two different channels have the id 1")));
  EXPECT_EQ(cost.messages, 2U);  // of the first, which counts
}

TEST(Bounds, AChunkInAChunkIsNotOpened) {
  Bytes inner;
  encode(Message{.channel_id = 1, .log_time_ns = 3}, inner);
  for (int depth = 0; depth < 50; ++depth) {
    Bytes outer;
    encode_chunk_head({.start_time_ns = 3, .end_time_ns = 3, .uncompressed_size = inner.size()}, inner.size(), outer);
    outer.insert(outer.end(), inner.begin(), inner.end());
    inner = outer;
  }
  Bytes file = beginning();
  file.insert(file.end(), inner.begin(), inner.end());
  const Cost cost = cost_of(file);
  EXPECT_EQ(cost.messages, 0U);
  EXPECT_THAT(cost.errors, ::testing::Contains(HasSubstr("a chunk in the chunk")));
}

TEST(Bounds, AFileThatGrowsIsReadAsItWasAndOpenedAgainShowsMore) {
  const testing::TemporaryFolder folder;
  const auto path = folder.path() / "growing.mcap";
  auto out = FileWritable::create(path);
  ASSERT_TRUE(out);
  Writer writer(**out);
  ASSERT_TRUE(writer.begin({}));
  ASSERT_TRUE(writer.write(Channel{.id = 1, .topic = "/a", .message_encoding = "x"}));
  const Bytes data(10'000);
  const auto add_chunk = [&](std::uint64_t time_ns) {
    ChunkBuilder chunk;
    for (std::uint32_t i = 0; i < 10; ++i) chunk.add(Message{1, i, time_ns + i, 0, data});
    EXPECT_TRUE(writer.write(chunk));
    EXPECT_TRUE((*out)->sync());
  };
  const auto count = [&](bool grow) {
    auto reader = IndexedReader::open(path);
    EXPECT_TRUE(reader);
    auto cursor = (*reader)->messages();
    std::uint64_t messages = 0;
    for (auto message = cursor.next();; message = cursor.next()) {
      EXPECT_TRUE(message);
      if (!message || !*message) return messages;
      if (grow && messages++ == 3) add_chunk(500);
      if (!grow) ++messages;
    }
  };
  add_chunk(100);
  EXPECT_EQ(count(true), 10U);   // as it was when it was opened
  EXPECT_EQ(count(false), 20U);  // as it is now
  add_chunk(900);
  ASSERT_TRUE(writer.finish());
  EXPECT_EQ(count(false), 30U);
}

}  // namespace
}  // namespace roseau::mcap
