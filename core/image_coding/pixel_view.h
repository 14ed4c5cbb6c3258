// PixelView: an image in memory that belongs to somebody else.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/frame.h"

namespace roseau::image {

/// Rows are `stride` bytes apart, top row first; `pixels` holds all of them (the last row may end with its last pixel).
/// mono16 is in the byte order of the machine.
struct PixelView {
  std::span<const std::byte> pixels;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t stride = 0;
  PixelFormat format = PixelFormat::mono8;

  std::size_t row_bytes() const { return width * bytes_per_pixel(format); }
};

inline PixelView view_of(const Frame& frame) { return {frame.bytes(), frame.width, frame.height, frame.stride, frame.format}; }

/// An error when the picture is empty or `pixels` is shorter than width, height and stride say.
Result<void> check(const PixelView& view);

/// The most bytes that the pixels of one picture may have, coded or decoded: what files of others may make us allocate.
inline constexpr std::size_t kMostPixelBytes = std::size_t{1} << 28U;

}  // namespace roseau::image
