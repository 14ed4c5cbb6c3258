// Options, grey conversion, coarse search.
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "tests/unit/tracking/scene.h"
#include "tracking/coarse_search.h"
#include "tracking/gray.h"
#include "tracking/options.h"

namespace roseau::tracking {
namespace {

TEST(Options, DefaultsAreValid) { EXPECT_TRUE(validate({}).has_value()); }

TEST(Options, SayWhichOneIsWrongAndWhatItMayBe) {
  TrackerOptions options;
  options.feature_count = 3;
  ASSERT_FALSE(validate(options));
  EXPECT_EQ(validate(options).error().message, "feature_count = 3: must be from 10 to 20000");
  options = {};
  options.least_correlation = std::nan("");
  EXPECT_FALSE(validate(options));
  options = {};
  options.mono16_significant_bits = 8;
  EXPECT_FALSE(validate(options));
}

TEST(Options, TargetsNeedANameForATopicAndSomeSize) {
  const auto with = [](std::vector<TargetRegion> targets) {
    TrackerOptions options;
    options.targets = std::move(targets);
    return validate(options);
  };
  EXPECT_TRUE(with({{"branch-1.left", {0, 0, 50, 50}}}));
  EXPECT_FALSE(with({{"", {0, 0, 50, 50}}}));
  EXPECT_FALSE(with({{"a/b", {0, 0, 50, 50}}}));
  EXPECT_FALSE(with({{"a", {0, 0, 50, 50}}, {"a", {60, 0, 50, 50}}}));
  EXPECT_FALSE(with({{"a", {0, 0, 5, 50}}}));
  EXPECT_NE(with({{"a", {0, 0, 5, 50}}}).error().message.find("\"a\""), std::string::npos);
}

Frame frame_with(PixelFormat format, std::uint32_t width, std::uint32_t height, const std::vector<std::byte>& bytes) {
  Frame frame;
  frame.format = format;
  frame.width = width;
  frame.height = height;
  frame.stride = static_cast<std::uint32_t>(width * bytes_per_pixel(format));
  FramePool pool(1, bytes.size());
  frame.pixels = pool.acquire();
  std::ranges::copy(bytes, frame.pixels.writable_bytes().begin());
  return frame;
}

std::vector<std::byte> words(std::initializer_list<std::uint16_t> values) {
  std::vector<std::byte> bytes;
  for (const std::uint16_t value : values) {
    bytes.push_back(static_cast<std::byte>(value & 0xff));
    bytes.push_back(static_cast<std::byte>(value >> 8));
  }
  return bytes;
}

TEST(Gray, EightBitGreyIsUsedInPlace) {
  const Frame frame = frame_with(PixelFormat::mono8, 2, 1, {std::byte{10}, std::byte{200}});
  cv::Mat storage;
  const auto gray = GrayConverter().convert(frame, storage);
  ASSERT_TRUE(gray);
  EXPECT_EQ(static_cast<const void*>(gray->data), static_cast<const void*>(frame.pixels.bytes().data()));
}

TEST(Gray, ColoursWeighAsTheEyeDoes) {
  const std::vector<std::byte> bytes = {std::byte{255}, std::byte{0}, std::byte{0}};
  cv::Mat storage;
  const auto as_bgr = GrayConverter().convert(frame_with(PixelFormat::bgr8, 1, 1, bytes), storage);
  ASSERT_TRUE(as_bgr);
  EXPECT_EQ(as_bgr->at<std::uint8_t>(0, 0), 29);  // 0.114 of 255: blue
  const auto as_rgb = GrayConverter().convert(frame_with(PixelFormat::rgb8, 1, 1, bytes), storage);
  ASSERT_TRUE(as_rgb);
  EXPECT_EQ(as_rgb->at<std::uint8_t>(0, 0), 76);  // 0.299 of 255: red
}

TEST(Gray, SixteenBitWordsAreShiftedByTheBitsTheFirstFrameUses) {
  GrayConverter converter;
  cv::Mat storage;
  const auto first = converter.convert(frame_with(PixelFormat::mono16, 2, 1, words({0x0fff, 0x0800})), storage);
  ASSERT_TRUE(first);
  EXPECT_EQ(converter.mono16_bits(), 12);
  EXPECT_EQ(first->at<std::uint8_t>(0, 0), 255);
  EXPECT_EQ(first->at<std::uint8_t>(0, 1), 128);
  // A darker frame later is darker, not stretched.
  const auto second = converter.convert(frame_with(PixelFormat::mono16, 2, 1, words({0x0100, 0x0010})), storage);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->at<std::uint8_t>(0, 0), 16);
  GrayConverter given(16);
  const auto shifted = given.convert(frame_with(PixelFormat::mono16, 2, 1, words({0x0100, 0xff00})), storage);
  ASSERT_TRUE(shifted);
  EXPECT_EQ(shifted->at<std::uint8_t>(0, 0), 1);
  EXPECT_EQ(shifted->at<std::uint8_t>(0, 1), 255);
}

TEST(Gray, AFrameWithTooFewBytesIsAnError) {
  Frame frame = frame_with(PixelFormat::mono8, 2, 1, {std::byte{1}, std::byte{2}});
  frame.height = 3;
  cv::Mat storage;
  EXPECT_FALSE(GrayConverter().convert(frame, storage));
  EXPECT_FALSE(GrayConverter().convert(Frame{}, storage));
}

TEST(CoarseSearch, PatchesVoteForTheirCommonShift) {
  testing::Picture before(160, 120);
  before.draw(testing::Texture(5), {});
  testing::Picture after(160, 120);
  after.draw(testing::Texture(5), {.shift = {9, -7}});
  after.scale_light(0.7, 20);
  cv::Mat from(120, 160, CV_8U);
  cv::Mat to(120, 160, CV_8U);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      from.at<std::uint8_t>(y, x) = before.pixel(x, y);
      to.at<std::uint8_t>(y, x) = after.pixel(x, y);
    }
  }
  std::vector<Patch> patches;
  std::vector<CoarseProbe> probes;
  for (int x = 40; x <= 120; x += 20) patches.push_back(*Patch::cut(from, x, 60));
  for (std::size_t i = 0; i < patches.size(); ++i) probes.push_back({&patches[i], {40 + 20 * static_cast<int>(i), 60}});
  const CoarseShift found = coarse_search(to, probes, 12);
  EXPECT_EQ(found.shift, Eigen::Vector2i(9, -7));
  EXPECT_GT(found.correlation, 0.98);
  EXPECT_LT(coarse_search(to, probes, 4).correlation, 0.7) << "out of reach";
  EXPECT_EQ(coarse_search(to, {}, 4).correlation, -1);
}

}  // namespace
}  // namespace roseau::tracking
