// PngEncoder: frames as PNG files, fast enough to do it while recording.
//
// Every row is filtered with PNG's average filter and the whole is one block of deflate with its own Huffman code, without any
// search for repetitions: noise in a camera's picture leaves none to be found. What comes out is a plain PNG file that any
// reader opens. Pixels come back bit for bit; rgb8 and bgr8 are stored as RGB, mono16 as 16-bit grey.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/image_coding/pixel_view.h"

namespace roseau::image {

/// One per thread. Keeps a few rows; allocates only when the pictures become wider.
class PngEncoder {
 public:
  /// A buffer of this size holds any picture of that size. What is written is never more than stored_bytes: the rest is room
  /// for the encoder to find out that a picture cannot be compressed.
  static std::size_t buffer_bytes(std::uint32_t width, std::uint32_t height, PixelFormat format);
  /// The file's size when nothing can be compressed: pixels, a byte per row, 5 bytes per 65535 bytes, and 63 bytes.
  static std::size_t stored_bytes(std::uint32_t width, std::uint32_t height, PixelFormat format);

  /// The file's size; the same picture gives the same bytes on every machine. Errors: the view is no picture (pixel_view.h),
  /// or `out` is smaller than buffer_bytes.
  Result<std::size_t> encode(const PixelView& view, std::span<std::byte> out);

 private:
  void prepare(const PixelView& view);
  const std::uint8_t* filtered_row(const PixelView& view, std::uint32_t y);
  const std::uint8_t* row_in_file_order(const PixelView& view, std::uint32_t y);
  std::size_t compress(const PixelView& view, std::span<std::byte> out, std::size_t most_bytes);
  std::size_t store(const PixelView& view, std::span<std::byte> out);

  std::vector<std::uint8_t> filtered_;  // filter byte and row
  struct Reordered {
    std::int64_t y = -1;  // which row it is
    std::vector<std::uint8_t> bytes;
  };
  std::array<Reordered, 2> reordered_;  // the last even and the last odd row; unused where PNG's order is the frame's
};

}  // namespace roseau::image
