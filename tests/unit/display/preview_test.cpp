#include "display/preview.h"

#include <gtest/gtest.h>
#include <turbojpeg.h>

#include <cstring>

namespace roseau::display {
namespace {

struct Decoded {
  int width = 0;
  int height = 0;
  std::vector<unsigned char> rgb;
  int at(int x, int y, std::size_t channel) const {
    return rgb.at((static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) * 3 + channel);
  }
};

Decoded decode(std::string_view jpeg) {
  Decoded out;
  const tjhandle handle = tjInitDecompress();
  const auto* bytes = reinterpret_cast<const unsigned char*>(jpeg.data());
  int subsampling = 0;
  int colorspace = 0;
  EXPECT_EQ(tjDecompressHeader3(handle, bytes, jpeg.size(), &out.width, &out.height, &subsampling, &colorspace), 0);
  out.rgb.resize(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height) * 3);
  EXPECT_EQ(tjDecompress2(handle, bytes, jpeg.size(), out.rgb.data(), out.width, 0, out.height, TJPF_RGB, 0), 0);
  tjDestroy(handle);
  return out;
}

/// Left half dark, right half bright; rows are padded with rubbish that must not be shown.
Frame halves(FramePool& pool, std::uint32_t width, std::uint32_t height, PixelFormat format) {
  const auto size = static_cast<std::uint32_t>(bytes_per_pixel(format));
  Frame frame{.pixels = pool.acquire(), .width = width, .height = height, .stride = width * size + 16, .format = format};
  const auto bytes = frame.pixels.writable_bytes();
  std::memset(bytes.data(), 0x7f, bytes.size());
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width * size; ++x) {
      bytes[y * frame.stride + x] = static_cast<std::byte>(x < width * size / 2 ? 40 : 200);
    }
  }
  return frame;
}

TEST(Preview, KeepsSmallPicturesAndScalesLargeOnesByTheirWidth) {
  FramePool pool(1, 2000 * 1100);
  PreviewEncoder encoder(960, 80);
  {
    const Frame small = halves(pool, 640, 480, PixelFormat::mono8);
    const Decoded shown = decode(*encoder.encode(small));
    EXPECT_EQ(shown.width, 640);
    EXPECT_EQ(shown.height, 480);
  }
  const Frame large = halves(pool, 1920, 1080, PixelFormat::mono8);
  const Decoded shown = decode(*encoder.encode(large));
  EXPECT_EQ(shown.width, 960);
  EXPECT_EQ(shown.height, 540);
  EXPECT_NEAR(shown.at(100, 100, 0), 40, 4);
  EXPECT_NEAR(shown.at(860, 400, 1), 200, 4);
}

TEST(Preview, ShowsTheUpperByteOfSixteenBits) {
  FramePool pool(1, 100 * 1000);
  PreviewEncoder encoder(960, 90);
  const Decoded shown = decode(*encoder.encode(halves(pool, 200, 100, PixelFormat::mono16)));
  EXPECT_NEAR(shown.at(20, 50, 0), 40, 4);
  EXPECT_NEAR(shown.at(180, 50, 0), 200, 4);
}

TEST(Preview, KeepsColoursApart) {
  FramePool pool(2, 64 * 64 * 3);
  PreviewEncoder encoder(960, 90);
  for (const PixelFormat format : {PixelFormat::bgr8, PixelFormat::rgb8}) {
    Frame frame{.pixels = pool.acquire(), .width = 64, .height = 64, .stride = 64 * 3, .format = format};
    const std::size_t red = format == PixelFormat::bgr8 ? 2 : 0;
    const auto bytes = frame.pixels.writable_bytes();
    std::memset(bytes.data(), 0, bytes.size());
    for (std::size_t i = red; i < bytes.size(); i += 3) bytes[i] = std::byte{220};
    const Decoded shown = decode(*encoder.encode(frame));
    EXPECT_GT(shown.at(32, 32, 0), 200);
    EXPECT_LT(shown.at(32, 32, 2), 30);
  }
}

TEST(Preview, RefusesAnEmptyPicture) {
  PreviewEncoder encoder(960, 80);
  EXPECT_FALSE(encoder.encode(Frame{}));
}

}  // namespace
}  // namespace roseau::display
