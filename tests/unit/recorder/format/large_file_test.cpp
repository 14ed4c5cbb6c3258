// A file above 4 GiB, whose pictures are all the same piece of memory: written, indexed, sought.
#include <gtest/gtest.h>

#include <map>

#include "core/check.h"
#include "recorder/format/indexed_reader.h"
#include "recorder/format/writer.h"

namespace roseau::mcap {
namespace {

/// Keeps large parts as a view, small ones as a copy: gigabytes in a few kilobytes.
struct ThinFile {
  struct Piece {
    std::vector<std::byte> copy;
    std::span<const std::byte> view;
    std::span<const std::byte> bytes() const { return copy.empty() ? view : std::span<const std::byte>(copy); }
  };
  std::map<std::uint64_t, Piece> pieces;  // by offset
  std::uint64_t size = 0;
};

class ThinWritable : public Writable {
 public:
  explicit ThinWritable(ThinFile& file) : file_(file) {}
  Result<void> append(std::span<const std::span<const std::byte>> parts) override {
    for (const auto& part : parts) {
      if (part.empty()) continue;
      ThinFile::Piece& piece = file_.pieces[file_.size];
      if (part.size() < (1U << 20U)) {
        piece.copy.assign(part.begin(), part.end());
      } else {
        piece.view = part;
      }
      file_.size += part.size();
    }
    return {};
  }
  Result<void> sync() override { return {}; }

 private:
  ThinFile& file_;
};

class ThinReadable : public Readable {
 public:
  explicit ThinReadable(const ThinFile& file) : file_(file) {}
  std::uint64_t size() const override { return file_.size; }
  Result<void> read(std::uint64_t offset, std::span<std::byte> to) override {
    ROSEAU_CHECK(offset <= file_.size && to.size() <= file_.size - offset);
    auto piece = std::prev(file_.pieces.upper_bound(offset));
    while (!to.empty()) {
      const auto rest = piece->second.bytes().subspan(offset - piece->first);
      const std::size_t some = std::min(rest.size(), to.size());
      std::ranges::copy(rest.first(some), to.begin());
      to = to.subspan(some);
      offset += some;
      ++piece;
    }
    return {};
  }

 private:
  const ThinFile& file_;
};

TEST(LargeFile, BeyondFourGibibytesIsWrittenAndSought) {
  constexpr std::uint64_t kFrames = 90;
  const std::vector<std::byte> pixels(std::size_t{50} << 20U, std::byte{0x5A});
  ThinFile file;
  ThinWritable out(file);
  Writer writer(out);
  ASSERT_TRUE(writer.begin({"x-test", "test"}));
  ASSERT_TRUE(writer.write(Schema{.id = 1, .name = "Frame", .encoding = "", .data = ""}));
  ASSERT_TRUE(writer.write(Channel{.id = 1, .schema_id = 1, .topic = "/camera", .message_encoding = "raw", .metadata = {}}));
  ASSERT_TRUE(writer.write(Channel{.id = 2, .schema_id = 1, .topic = "/number", .message_encoding = "raw", .metadata = {}}));
  for (std::uint64_t i = 0; i < kFrames; ++i) {
    ChunkBuilder chunk;
    const std::byte number[] = {static_cast<std::byte>(i)};
    chunk.add({.channel_id = 1, .sequence = static_cast<std::uint32_t>(i), .log_time_ns = 2 * i + 1, .data = number}, pixels);
    chunk.add({.channel_id = 2, .sequence = static_cast<std::uint32_t>(i), .log_time_ns = 2 * i + 2, .data = number});
    ASSERT_TRUE(writer.write(chunk));
  }
  const std::uint64_t promised = writer.bytes_written() + writer.end_bytes();
  ASSERT_TRUE(writer.finish());
  ASSERT_GT(file.size, std::uint64_t{1} << 32U);
  EXPECT_LE(file.size, promised) << "what the end takes was said to be less";

  const auto reader = IndexedReader::open(std::make_unique<ThinReadable>(file));
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_TRUE((*reader)->index().complete);
  EXPECT_EQ((*reader)->index().statistics.message_count, 2 * kFrames);
  EXPECT_EQ((*reader)->index().blocks.size(), kFrames);
  for (const std::uint64_t i : {kFrames - 1, kFrames / 2, std::uint64_t{0}}) {  // beyond 4 GiB, before, and at the front
    auto cursor = (*reader)->messages({.channels = {{1, 2}}, .start_time_ns = 2 * i + 1});
    for (const std::uint16_t channel : {std::uint16_t{1}, std::uint16_t{2}}) {
      const auto message = cursor.next();
      ASSERT_TRUE(message) << message.error().message;
      ASSERT_TRUE(*message);
      EXPECT_EQ((*message)->channel->id, channel);
      EXPECT_EQ((*message)->message.sequence, i);
      EXPECT_EQ((*message)->message.data[0], static_cast<std::byte>(i));
      EXPECT_EQ((*message)->message.data.size(), channel == 1 ? pixels.size() + 1 : 1);
    }
  }
}

}  // namespace
}  // namespace roseau::mcap
