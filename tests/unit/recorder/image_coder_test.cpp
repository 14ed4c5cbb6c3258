#include "recorder/image_coder.h"

#include <gtest/gtest.h>

#include "core/image_coding/image_decoder.h"
#include "core/image_coding/png_encoder.h"
#include "tests/support/samples.h"

namespace roseau::recorder {
namespace {

constexpr auto kNever = std::chrono::steady_clock::time_point::max();

class ImageCoderTest : public ::testing::Test {
 protected:
  QueuedSample frame(std::uint32_t number, std::uint32_t width = 64, std::uint32_t height = 48) {
    QueuedSample queued{.sample = testing::filled_sample(SampleKind::drop, streams, pixels)};
    queued.sample.header.sequence = number;
    Frame filled = testing::filled_frame(pixels, width, height, width);
    filled.pixels.writable_bytes()[0] = static_cast<std::byte>(number);
    queued.sample.payload = std::move(filled);
    return queued;
  }
  QueuedSample small(std::uint32_t number) {
    QueuedSample queued{.sample = testing::filled_sample(SampleKind::wind, streams, pixels)};
    queued.sample.header.sequence = number;
    return queued;
  }
  StreamTable streams;
  FramePool pixels{64, 64 * 48};
};

TEST_F(ImageCoderTest, KeepsTheOrderAndCodesBitForBit) {
  ImageCoder coder(3);
  EXPECT_TRUE(coder.empty());
  EXPECT_FALSE(coder.take(kNever));
  std::vector<Frame> originals;
  std::vector<QueuedSample> all;
  for (std::uint32_t i = 0; i < 40; ++i) {
    all.push_back(i % 3 == 0 ? small(i) : frame(i));
    if (i % 3 != 0) originals.push_back(std::get<Frame>(all.back().sample.payload));
    coder.submit(all.back(), i % 3 != 0);
  }
  image::ImageDecoder decoder;
  std::vector<std::byte> decoded(64 * 48);
  std::size_t frames = 0;
  for (std::uint32_t i = 0; i < 40; ++i) {
    const auto done = coder.take(kNever);
    ASSERT_TRUE(done);
    EXPECT_FALSE(done->error);
    EXPECT_EQ(done->queued.sample.header.sequence, i);
    if (i % 3 == 0) continue;
    const auto& coded = std::get<Frame>(done->queued.sample.payload);
    ASSERT_TRUE(coded.coded);
    EXPECT_EQ(coded.coded.format, ImageStorage::png);
    EXPECT_FALSE(coded.pixels);  // the camera has its buffer back
    ASSERT_TRUE(decoder.decode(coded.coded.bytes(), decoded));
    EXPECT_TRUE(std::ranges::equal(decoded, originals[frames++].bytes()));
  }
  EXPECT_TRUE(coder.empty());
}

TEST_F(ImageCoderTest, WaitsForBuffersAndGoesOnWhenTheyComeBack) {
  ImageCoder coder(2);
  for (std::uint32_t i = 0; i < 60; ++i) coder.submit(frame(i), true);  // more than it has buffers
  std::vector<ImageCoder::Done> held;
  for (std::uint32_t i = 0; i < 60; ++i) {
    auto done = coder.take(kNever);
    ASSERT_TRUE(done);
    EXPECT_EQ(done->queued.sample.header.sequence, i);
    held.push_back(std::move(*done));
    if (held.size() == 16) held.clear();
  }
}

TEST_F(ImageCoderTest, LargerPicturesGetLargerBuffers) {
  ImageCoder coder(1);
  for (std::uint32_t i = 1; i < 20; ++i) coder.submit(frame(i, i, 2 * i), true);
  for (std::uint32_t i = 1; i < 20; ++i) {
    const auto done = coder.take(kNever);
    ASSERT_TRUE(done && !done->error);
    EXPECT_EQ(image::read_info(std::get<Frame>(done->queued.sample.payload).coded.bytes())->height, 2 * i);
  }
}

TEST_F(ImageCoderTest, AFrameThatCannotBeCodedIsReportedInItsPlace) {
  ImageCoder coder(1);
  QueuedSample broken = frame(1);
  std::get<Frame>(broken.sample.payload).width = 0;
  coder.submit(frame(0), true);
  coder.submit(broken, true);
  coder.submit(small(2), false);
  EXPECT_FALSE(coder.take(kNever)->error);
  const auto lost = coder.take(kNever);
  ASSERT_TRUE(lost && lost->error);
  EXPECT_EQ(lost->queued.sample.header.sequence, 1U);
  EXPECT_EQ(coder.take(kNever)->queued.sample.header.sequence, 2U);
}

TEST_F(ImageCoderTest, CanBeLeftInTheMiddle) {
  ImageCoder coder(2);
  for (std::uint32_t i = 0; i < 50; ++i) coder.submit(frame(i), true);
  coder.take(kNever);
}

}  // namespace
}  // namespace roseau::recorder
