// Reading pictures of other programs, and broken ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spng.h>
#include <zlib.h>

#include <array>
#include <cstdlib>

#include "core/image_coding/image_decoder.h"
#include "core/image_coding/jpeg.h"
#include "core/image_coding/png_encoder.h"
#include "core/image_coding/png_format.h"
#include "tests/unit/core/image_coding/pictures.h"

namespace roseau::image {
namespace {

using ::testing::HasSubstr;

struct Flavour {
  std::uint8_t colour;
  std::uint8_t depth;
  std::uint8_t interlace;
};

constexpr std::uint32_t kWidth = 37;
constexpr std::uint32_t kHeight = 21;

std::size_t raw_row_bytes(const Flavour& flavour) {
  constexpr std::array<std::size_t, 7> kChannels{1, 0, 3, 1, 2, 0, 4};
  return (kWidth * kChannels.at(flavour.colour) * flavour.depth + 7) / 8;
}

/// A file by libspng, with filters as it chooses them.
std::vector<std::byte> written_by_libspng(const Flavour& flavour) {
  spng_ctx* context = spng_ctx_new(SPNG_CTX_ENCODER);
  spng_set_option(context, SPNG_ENCODE_TO_BUFFER, 1);
  spng_ihdr header{.width = kWidth,
                   .height = kHeight,
                   .bit_depth = flavour.depth,
                   .color_type = flavour.colour,
                   .compression_method = 0,
                   .filter_method = 0,
                   .interlace_method = flavour.interlace};
  EXPECT_EQ(spng_set_ihdr(context, &header), 0);
  if (flavour.colour == SPNG_COLOR_TYPE_INDEXED) {
    spng_plte palette{};
    palette.n_entries = 1U << flavour.depth;
    for (std::uint32_t i = 0; i < palette.n_entries; ++i) {
      palette.entries[i] = {static_cast<std::uint8_t>(i * 7), static_cast<std::uint8_t>(255 - i), static_cast<std::uint8_t>(i),
                            0};
    }
    EXPECT_EQ(spng_set_plte(context, &palette), 0);
  }
  std::vector<std::uint8_t> raw(raw_row_bytes(flavour) * kHeight);
  for (std::size_t i = 0; i < raw.size(); ++i) raw[i] = static_cast<std::uint8_t>(i * i / 50 + i);
  EXPECT_EQ(spng_encode_image(context, raw.data(), raw.size(), SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE), 0);
  std::size_t size = 0;
  int error = 0;
  void* buffer = spng_get_png_buffer(context, &size, &error);
  EXPECT_EQ(error, 0);
  const auto* bytes = static_cast<const std::byte*>(buffer);
  std::vector<std::byte> file(bytes, bytes + size);
  std::free(buffer);
  spng_ctx_free(context);
  return file;
}

std::vector<std::byte> read_by_libspng(const std::vector<std::byte>& file, int format) {
  spng_ctx* context = spng_ctx_new(0);
  std::size_t size = 0;
  EXPECT_EQ(spng_set_png_buffer(context, file.data(), file.size()), 0);
  EXPECT_EQ(spng_decoded_image_size(context, format, &size), 0);
  std::vector<std::byte> pixels(size);
  EXPECT_EQ(spng_decode_image(context, pixels.data(), size, format, 0), 0);
  spng_ctx_free(context);
  return pixels;
}

TEST(ReadPng, EveryFlavourOfOtherPrograms) {
  constexpr Flavour kFlavours[] = {{0, 1, 0},  {0, 2, 0}, {0, 4, 0}, {0, 8, 0},  {0, 16, 0}, {2, 8, 0},
                                   {2, 16, 0}, {3, 1, 0}, {3, 8, 0}, {4, 8, 0},  {4, 16, 0}, {6, 8, 0},
                                   {6, 16, 0}, {0, 8, 1}, {2, 8, 1}, {0, 16, 1}, {6, 8, 1}};
  ImageDecoder decoder;
  for (const Flavour& flavour : kFlavours) {
    SCOPED_TRACE(testing::Message() << "colour " << int{flavour.colour} << " depth " << int{flavour.depth} << " interlace "
                                    << int{flavour.interlace});
    const auto file = written_by_libspng(flavour);
    const auto info = read_info(file);
    ASSERT_TRUE(info) << info.error().message;
    const PixelFormat expected = flavour.colour != 0   ? PixelFormat::rgb8
                                 : flavour.depth == 16 ? PixelFormat::mono16
                                                       : PixelFormat::mono8;
    EXPECT_EQ(info->format, expected);
    std::vector<std::byte> pixels(info->pixel_bytes());
    const auto decoded = decoder.decode(file, pixels);
    ASSERT_TRUE(decoded) << decoded.error().message;
    const int format = expected == PixelFormat::rgb8     ? SPNG_FMT_RGB8
                       : expected == PixelFormat::mono16 ? SPNG_FMT_PNG
                                                         : SPNG_FMT_G8;
    EXPECT_EQ(pixels, read_by_libspng(file, format));
  }
}

/// A PNG of roseau's kind with each row filtered by the given filter; the rows' contents are `rows`.
std::vector<std::byte> png_file(std::uint32_t width, std::uint32_t height, const std::vector<std::uint8_t>& deflated,
                                std::size_t pieces = 1) {
  std::vector<std::uint8_t> file(png::kSignature.begin(), png::kSignature.end());
  const auto add_chunk = [&file](std::string_view type, std::span<const std::uint8_t> data) {
    std::vector<std::uint8_t> chunk(data.size() + 12);
    png::put_be32(chunk.data(), static_cast<std::uint32_t>(data.size()));
    std::ranges::copy(type, chunk.begin() + 4);
    std::ranges::copy(data, chunk.begin() + 8);
    const auto crc = ::crc32(0, chunk.data() + 4, static_cast<unsigned>(data.size() + 4));
    png::put_be32(chunk.data() + 8 + data.size(), static_cast<std::uint32_t>(crc));
    file.insert(file.end(), chunk.begin(), chunk.end());
  };
  std::array<std::uint8_t, 13> header{};
  png::put_be32(header.data(), width);
  png::put_be32(header.data() + 4, height);
  header[8] = 8;
  add_chunk("IHDR", header);
  for (std::size_t piece = 0; piece < pieces; ++piece) {
    const std::size_t begin = deflated.size() * piece / pieces;
    add_chunk("IDAT", std::span(deflated).subspan(begin, deflated.size() * (piece + 1) / pieces - begin));
  }
  add_chunk("IEND", {});
  const auto bytes = std::as_bytes(std::span(file));
  return {bytes.begin(), bytes.end()};
}

std::vector<std::uint8_t> deflated(const std::vector<std::uint8_t>& raw) {
  std::vector<std::uint8_t> out(::compressBound(raw.size()));
  uLongf size = out.size();
  EXPECT_EQ(::compress(out.data(), &size, raw.data(), raw.size()), Z_OK);
  out.resize(size);
  return out;
}

TEST(ReadPng, EveryFilterInAnyNumberOfPieces) {
  std::vector<std::uint8_t> rows;
  for (unsigned y = 0; y < 20; ++y) {
    rows.push_back(static_cast<std::uint8_t>(y % 5));
    for (unsigned x = 0; x < 31; ++x) rows.push_back(static_cast<std::uint8_t>(x * x + 7 * y));
  }
  const auto whole = png_file(31, 20, deflated(rows));
  ImageDecoder decoder;
  std::vector<std::byte> pixels(31 * 20);
  ASSERT_TRUE(decoder.decode(whole, pixels));
  EXPECT_EQ(pixels, read_by_libspng(whole, SPNG_FMT_G8));
  std::vector<std::byte> again(pixels.size());
  ASSERT_TRUE(decoder.decode(png_file(31, 20, deflated(rows), 7), again));
  EXPECT_EQ(again, pixels);
  rows[32] = 5;
  const auto unknown = decoder.decode(png_file(31, 20, deflated(rows)), pixels);
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().message, HasSubstr("filter"));
}

TEST(ReadPng, MoreOrLessThanThePictureIsAnError) {
  ImageDecoder decoder;
  std::vector<std::byte> pixels(31 * 20);
  for (const std::size_t size : {32U * 20 - 1, 32U * 20 + 1, 32U * 2000}) {
    const auto decoded = decoder.decode(png_file(31, 20, deflated(std::vector<std::uint8_t>(size))), pixels);
    ASSERT_FALSE(decoded) << size;
    EXPECT_EQ(decoded.error().code, ErrorCode::corrupt);
  }
}

TEST(ReadInfo, RefusesPicturesLargerThanTheirFilesCouldBe) {
  const auto deflated_nothing = deflated({0});
  for (const auto& [width, height] :
       {std::pair{20'000U, 10'000U}, {70'000U, 70'000U}, {0xFFFFFFFFU, 0xFFFFFFFFU}, {2'000'000U, 1U}}) {
    const auto info = read_info(png_file(width, height, deflated_nothing));
    ASSERT_FALSE(info) << width;
    EXPECT_EQ(info.error().code, ErrorCode::corrupt);
  }
  EXPECT_FALSE(read_info(png_file(0, 5, deflated_nothing)));
  EXPECT_FALSE(read_info({}));
  EXPECT_EQ(read_info(std::as_bytes(std::span("GIF89a..."))).error().code, ErrorCode::unsupported);

  // JPEG: height and width are in the frame's header, behind FF C0, its length and the number of bits.
  JpegEncoder encoder(90);
  const auto picture = scene(PixelFormat::mono8, 64, 64);
  std::vector<std::byte> file(JpegEncoder::buffer_bytes(64, 64, PixelFormat::mono8));
  file.resize(*encoder.encode(picture.view(), file));
  const std::array kFrame{std::byte{0xFF}, std::byte{0xC0}};
  const auto frame = std::ranges::search(file, kFrame).begin();
  std::fill_n(frame + 5, 4, std::byte{0xF0});
  const auto info = read_info(file);
  ASSERT_FALSE(info);
  EXPECT_THAT(info.error().message, HasSubstr("more pixels"));
}

TEST(Decode, WantsRoomAndTheRightKind) {
  PngEncoder encoder;
  const auto picture = scene(PixelFormat::mono8, 30, 20);
  std::vector<std::byte> file(PngEncoder::buffer_bytes(30, 20, PixelFormat::mono8));
  file.resize(*encoder.encode(picture.view(), file));
  ImageDecoder decoder;
  std::vector<std::byte> pixels(599);
  EXPECT_EQ(decoder.decode(file, pixels).error().code, ErrorCode::invalid_argument);
  pixels.resize(600);
  EXPECT_EQ(decoder.decode(file, pixels, PixelFormat::bgr8).error().code, ErrorCode::corrupt);
  EXPECT_TRUE(decoder.decode(file, pixels, PixelFormat::mono8));
}

/// Every byte changed in three ways, and the file cut off everywhere: never anything but an error or a picture of that size.
std::size_t count_accepted(std::vector<std::byte> file, std::size_t pixel_bytes) {
  ImageDecoder decoder;
  std::vector<std::byte> pixels(pixel_bytes);
  std::size_t accepted = 0;
  for (std::size_t i = 0; i < file.size(); ++i) {
    for (const int flip : {0x01, 0x80, 0xFF}) {
      file[i] ^= static_cast<std::byte>(flip);
      const auto info = read_info(file);
      EXPECT_TRUE(!info || info->pixel_bytes() <= kMostPixelBytes);
      accepted += decoder.decode(file, pixels) ? 1 : 0;
      file[i] ^= static_cast<std::byte>(flip);
    }
    EXPECT_FALSE(decoder.decode(std::span(file).first(i), pixels)) << i;
  }
  EXPECT_TRUE(decoder.decode(file, pixels));
  return accepted;
}

TEST(Decode, BrokenFilesAreErrors) {
  const auto picture = scene(PixelFormat::mono8, 30, 20);
  PngEncoder png;
  std::vector<std::byte> file(PngEncoder::buffer_bytes(30, 20, PixelFormat::mono8));
  file.resize(*png.encode(picture.view(), file));
  // Every byte of a PNG is under a checksum, or one itself.
  EXPECT_EQ(count_accepted(file, 600), 0U);
  for (const Flavour& flavour : {Flavour{3, 4, 0}, Flavour{6, 8, 1}})
    count_accepted(written_by_libspng(flavour), kWidth * kHeight * 3);

  JpegEncoder jpeg(80);
  file.resize(JpegEncoder::buffer_bytes(30, 20, PixelFormat::mono8));
  file.resize(*jpeg.encode(picture.view(), file));
  count_accepted(file, 600);
}

}  // namespace
}  // namespace roseau::image
