// Pictures for the tests of image coding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/image_coding/pixel_view.h"

namespace roseau::image {

struct Picture {
  std::vector<std::byte> pixels;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t stride = 0;
  PixelFormat format = PixelFormat::mono8;

  PixelView view() const { return {pixels, width, height, stride, format}; }
  /// Without what is between the rows.
  std::vector<std::byte> packed() const {
    std::vector<std::byte> rows;
    for (std::uint32_t y = 0; y < height; ++y) {
      const auto row = std::span(pixels).subspan(std::size_t{y} * stride, view().row_bytes());
      rows.insert(rows.end(), row.begin(), row.end());
    }
    return rows;
  }
};

/// `value(x, y, channel)` gives 0 to 65535 for mono16, else 0 to 255. What is between the rows is 0xA5.
inline Picture draw(PixelFormat format, std::uint32_t width, std::uint32_t height, std::uint32_t gap_bytes,
                    const std::function<std::uint32_t(std::uint32_t, std::uint32_t, std::uint32_t)>& value) {
  Picture picture{.width = width, .height = height, .format = format};
  picture.stride = static_cast<std::uint32_t>(width * bytes_per_pixel(format)) + gap_bytes;
  picture.pixels.assign(std::size_t{picture.stride} * height, std::byte{0xA5});
  const std::size_t channel_bytes = format == PixelFormat::mono16 ? 2 : 1;
  const auto channels = static_cast<std::uint32_t>(bytes_per_pixel(format) / channel_bytes);
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      for (std::uint32_t channel = 0; channel < channels; ++channel) {
        const std::uint32_t number = value(x, y, channel);
        std::byte* at =
            picture.pixels.data() + std::size_t{y} * picture.stride + (std::size_t{x} * channels + channel) * channel_bytes;
        std::memcpy(at, &number, channel_bytes);  // the machine is little-endian
      }
    }
  }
  return picture;
}

inline Picture constant(PixelFormat format, std::uint32_t width, std::uint32_t height, std::uint32_t gap_bytes = 0) {
  return draw(format, width, height, gap_bytes, [](auto, auto, auto channel) { return 77 + 20 * channel; });
}

inline Picture noise(PixelFormat format, std::uint32_t width, std::uint32_t height, std::uint32_t gap_bytes = 0) {
  std::mt19937 random(width * 31 + height);
  return draw(format, width, height, gap_bytes,
              [&](auto, auto, auto) { return static_cast<std::uint32_t>(random() & 0xFFFF); });
}

/// What a camera might see: slopes and edges with some noise.
inline Picture scene(PixelFormat format, std::uint32_t width, std::uint32_t height, std::uint32_t gap_bytes = 0) {
  std::mt19937 random(width + 7 * height);
  const std::uint32_t scale = format == PixelFormat::mono16 ? 200 : 1;
  return draw(format, width, height, gap_bytes, [&](auto x, auto y, auto channel) {
    const std::uint32_t leaf = ((x / 23 + y / 17) % 3) * 40;
    return scale * (20 + (x + 2 * y + 10 * channel) % 80 + leaf) + static_cast<std::uint32_t>(random() % (4 * scale));
  });
}

inline constexpr PixelFormat kFormats[] = {PixelFormat::mono8, PixelFormat::mono16, PixelFormat::bgr8, PixelFormat::rgb8};

}  // namespace roseau::image
