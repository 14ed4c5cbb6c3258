#include "core/image_coding/png_encoder.h"

#include <gtest/gtest.h>
#include <png.h>
#include <spng.h>

#include "core/image_coding/image_decoder.h"
#include "tests/unit/core/image_coding/pictures.h"

namespace roseau::image {
namespace {

std::vector<std::byte> encode(PngEncoder& encoder, const Picture& picture) {
  std::vector<std::byte> out(PngEncoder::buffer_bytes(picture.width, picture.height, picture.format));
  const auto size = encoder.encode(picture.view(), out);
  EXPECT_TRUE(size) << size.error().message;
  out.resize(size ? *size : 0);
  return out;
}

std::vector<std::byte> encode(const Picture& picture) {
  PngEncoder encoder;
  return encode(encoder, picture);
}

std::vector<std::byte> decoded_by_us(const std::vector<std::byte>& file, PixelFormat wanted) {
  const auto info = read_info(file);
  EXPECT_TRUE(info) << info.error().message;
  if (!info) return {};
  std::vector<std::byte> pixels(info->pixel_bytes());
  ImageDecoder decoder;
  const auto decoded = decoder.decode(file, pixels, wanted);
  EXPECT_TRUE(decoded) << decoded.error().message;
  return pixels;
}

std::vector<std::byte> decoded_by_libpng(const std::vector<std::byte>& file, PixelFormat format) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&image, file.data(), file.size()), 0) << image.message;
  image.format = format == PixelFormat::mono8 ? PNG_FORMAT_GRAY : format == PixelFormat::rgb8 ? PNG_FORMAT_RGB : PNG_FORMAT_BGR;
  std::vector<std::byte> pixels(PNG_IMAGE_SIZE(image));
  EXPECT_NE(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr), 0) << image.message;
  EXPECT_EQ(image.warning_or_error, 0U) << image.message;
  return pixels;
}

std::vector<std::byte> decoded_by_libspng(const std::vector<std::byte>& file) {
  spng_ctx* context = spng_ctx_new(0);
  std::size_t size = 0;
  EXPECT_EQ(spng_set_png_buffer(context, file.data(), file.size()), 0);
  EXPECT_EQ(spng_decoded_image_size(context, SPNG_FMT_PNG, &size), 0);
  std::vector<std::byte> pixels(size);
  EXPECT_EQ(spng_decode_image(context, pixels.data(), size, SPNG_FMT_PNG, 0), 0);
  spng_ctx_free(context);
  return pixels;
}

void expect_read_by_all(const Picture& picture) {
  SCOPED_TRACE(std::string(to_string(picture.format)) + " " + std::to_string(picture.width) + "x" +
               std::to_string(picture.height) + " stride " + std::to_string(picture.stride));
  const auto file = encode(picture);
  EXPECT_LE(file.size(), PngEncoder::stored_bytes(picture.width, picture.height, picture.format));
  EXPECT_EQ(decoded_by_us(file, picture.format), picture.packed());
  if (picture.format != PixelFormat::mono16) {  // libpng's simple interface gives it as linear light
    EXPECT_EQ(decoded_by_libpng(file, picture.format), picture.packed());
  }
  if (picture.format != PixelFormat::bgr8) {  // libspng knows rgb only
    EXPECT_EQ(decoded_by_libspng(file), picture.packed());
  }
}

TEST(Png, EveryFormatSizeAndContentComesBackBitForBit) {
  constexpr std::pair<std::uint32_t, std::uint32_t> kSizes[] = {{1, 1},  {2, 1},  {1, 9},   {3, 2},   {15, 4},  {16, 16},
                                                                {17, 5}, {33, 7}, {64, 64}, {65, 40}, {333, 51}};
  for (const PixelFormat format : kFormats) {
    for (const auto& [width, height] : kSizes) {
      for (const std::uint32_t gap : {0U, 6U}) {
        expect_read_by_all(constant(format, width, height, gap));
        expect_read_by_all(noise(format, width, height, gap));
        expect_read_by_all(scene(format, width, height, gap));
      }
    }
  }
}

TEST(Png, LargePicturesUseAPartOfTheirRowsForTheCode) {
  // 8 MB: the code is made from every eighth row. Rows in between that look quite different must be coded as well.
  const auto picture = draw(PixelFormat::mono8, 4000, 2000, 0,
                            [](auto x, auto y, auto) { return y % 8 == 0 ? 100U : (x * 2654435761U + y * 40503U) >> 13U; });
  const auto file = encode(picture);
  EXPECT_LE(file.size(), PngEncoder::stored_bytes(4000, 2000, PixelFormat::mono8));
  EXPECT_EQ(decoded_by_libspng(file), picture.packed());
  expect_read_by_all(scene(PixelFormat::mono8, 1280, 1024));
}

TEST(Png, WhatCannotBeCompressedIsStored) {
  const auto picture = noise(PixelFormat::mono8, 400, 300);
  EXPECT_EQ(encode(picture).size(), PngEncoder::stored_bytes(400, 300, PixelFormat::mono8));
  EXPECT_EQ(PngEncoder::stored_bytes(400, 300, PixelFormat::mono8), 401U * 300 + 2 * 5 + 63);
}

TEST(Png, CompressesWhatCamerasSee) {
  const auto picture = scene(PixelFormat::mono8, 640, 480);
  EXPECT_LT(encode(picture).size() * 2, picture.pixels.size());
  const auto flat = constant(PixelFormat::mono8, 640, 480);
  EXPECT_LT(encode(flat).size() * 7, flat.pixels.size());
}

TEST(Png, WritesNothingBehindItsBuffer) {
  for (const auto& picture :
       {noise(PixelFormat::mono8, 301, 40), scene(PixelFormat::bgr8, 301, 40), noise(PixelFormat::mono16, 7, 3)}) {
    const std::size_t size = PngEncoder::buffer_bytes(picture.width, picture.height, picture.format);
    std::vector<std::byte> out(size + 64, std::byte{0x5A});
    PngEncoder encoder;
    ASSERT_TRUE(encoder.encode(picture.view(), std::span(out).first(size)));
    EXPECT_EQ(std::vector(out.end() - 64, out.end()), std::vector(64, std::byte{0x5A}));
  }
}

TEST(Png, AnEncoderThatWasUsedBeforeGivesTheSameBytes) {
  PngEncoder used;
  encode(used, scene(PixelFormat::bgr8, 100, 30));
  encode(used, noise(PixelFormat::mono16, 50, 60));
  for (const PixelFormat format : kFormats) {
    const auto picture = scene(format, 90, 31);
    EXPECT_EQ(encode(used, picture), encode(picture));
  }
}

TEST(Png, RefusesWhatIsNoPicture) {
  PngEncoder encoder;
  std::vector<std::byte> out(10'000);
  const auto picture = scene(PixelFormat::mono8, 20, 10);
  const auto code_of = [&](PixelView view) { return encoder.encode(view, out).error().code; };
  EXPECT_EQ(code_of({}), ErrorCode::invalid_argument);
  auto view = picture.view();
  view.stride = 19;
  EXPECT_EQ(code_of(view), ErrorCode::invalid_argument);
  view = picture.view();
  view.height = 11;
  EXPECT_EQ(code_of(view), ErrorCode::invalid_argument);
  out.resize(PngEncoder::buffer_bytes(20, 10, PixelFormat::mono8) - 1);
  EXPECT_EQ(code_of(picture.view()), ErrorCode::invalid_argument);
}

}  // namespace
}  // namespace roseau::image
