#include "core/image_coding/jpeg.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/image_coding/image_decoder.h"
#include "tests/unit/core/image_coding/pictures.h"

namespace roseau::image {
namespace {

std::vector<std::byte> encode(const Picture& picture, int quality) {
  JpegEncoder encoder(quality);
  std::vector<std::byte> out(JpegEncoder::buffer_bytes(picture.width, picture.height, picture.format));
  const auto size = encoder.encode(picture.view(), out);
  EXPECT_TRUE(size) << size.error().message;
  out.resize(size ? *size : 0);
  return out;
}

Picture smooth(PixelFormat format, std::uint32_t gap_bytes) {
  return draw(format, 67, 45, gap_bytes, [](auto x, auto y, auto channel) { return 40 + x + y + 30 * channel; });
}

double rms(const std::vector<std::byte>& a, const std::vector<std::byte>& b) {
  EXPECT_EQ(a.size(), b.size());
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::pow(static_cast<double>(a[i]) - static_cast<double>(b[i]), 2);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST(Jpeg, ComesBackNearlyInEachFormat) {
  for (const PixelFormat format : {PixelFormat::mono8, PixelFormat::bgr8, PixelFormat::rgb8}) {
    for (const std::uint32_t gap : {0U, 5U}) {
      const auto picture = smooth(format, gap);
      const auto file = encode(picture, 95);
      const auto info = read_info(file);
      ASSERT_TRUE(info);
      EXPECT_EQ(info->coding, ImageStorage::jpeg);
      EXPECT_EQ(info->width, 67U);
      EXPECT_EQ(info->height, 45U);
      EXPECT_EQ(info->format, format == PixelFormat::mono8 ? PixelFormat::mono8 : PixelFormat::rgb8);
      std::vector<std::byte> pixels(info->pixel_bytes());
      ImageDecoder decoder;
      const auto decoded = decoder.decode(file, pixels, format);
      ASSERT_TRUE(decoded) << decoded.error().message;
      EXPECT_EQ(decoded->format, format);
      EXPECT_LT(rms(pixels, picture.packed()), 1.5) << to_string(format);
    }
  }
}

TEST(Jpeg, QualityMatters) {
  const auto picture = scene(PixelFormat::mono8, 320, 200);
  EXPECT_LT(encode(picture, 50).size(), encode(picture, 95).size() / 2);
}

TEST(Jpeg, HoldsNoSixteenBits) {
  const auto picture = scene(PixelFormat::mono16, 32, 20);
  JpegEncoder encoder(90);
  std::vector<std::byte> out(JpegEncoder::buffer_bytes(32, 20, PixelFormat::mono16));
  const auto size = encoder.encode(picture.view(), out);
  ASSERT_FALSE(size);
  EXPECT_EQ(size.error().code, ErrorCode::unsupported);
  EXPECT_THAT(size.error().message, ::testing::HasSubstr("png or raw"));
}

TEST(Jpeg, RefusesASmallBuffer) {
  const auto picture = scene(PixelFormat::mono8, 32, 20);
  JpegEncoder encoder(90);
  std::vector<std::byte> out(JpegEncoder::buffer_bytes(32, 20, PixelFormat::mono8) - 1);
  EXPECT_EQ(encoder.encode(picture.view(), out).error().code, ErrorCode::invalid_argument);
}

TEST(Jpeg, HalfAFileIsNoPicture) {
  const auto file = encode(scene(PixelFormat::mono8, 320, 200), 90);
  std::vector<std::byte> pixels(320 * 200);
  ImageDecoder decoder;
  for (const double share : {0.999, 0.9, 0.5, 0.2, 0.1, 0.01}) {
    const auto part = std::span(file).first(static_cast<std::size_t>(share * static_cast<double>(file.size())));
    EXPECT_FALSE(decoder.decode(part, pixels)) << share;
  }
}

}  // namespace
}  // namespace roseau::image
