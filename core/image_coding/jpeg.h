// JPEG by libjpeg-turbo, the only place that knows it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "core/image_coding/image_decoder.h"
#include "core/image_coding/pixel_view.h"

namespace roseau::image {

/// Colour at half its resolution, as cameras and browsers have it; grey stays grey.
class JpegEncoder {
 public:
  /// The exact transform gives the same bytes on every CPU; the fast one is for pictures that are only looked at.
  enum class Transform : std::uint8_t { exact, fast };
  /// `quality` from 1 to 100.
  explicit JpegEncoder(int quality, Transform transform = Transform::exact);
  ~JpegEncoder();
  JpegEncoder(const JpegEncoder&) = delete;
  JpegEncoder& operator=(const JpegEncoder&) = delete;

  /// A buffer of this size holds any picture of that size.
  static std::size_t buffer_bytes(std::uint32_t width, std::uint32_t height, PixelFormat format);

  /// The file's size. Errors: no picture; mono16, which JPEG does not know; `out` is smaller than buffer_bytes.
  Result<std::size_t> encode(const PixelView& view, std::span<std::byte> out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

bool is_jpeg(std::span<const std::byte> coded);
Result<CodedInfo> read_jpeg_info(std::span<const std::byte> coded);

/// For ImageDecoder. Exact: the same pixels on every CPU.
class JpegDecoder {
 public:
  JpegDecoder();
  ~JpegDecoder();
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;
  /// `info` is the file's; `out` has exactly its pixels' size.
  Result<void> decode(std::span<const std::byte> coded, const CodedInfo& info, std::span<std::byte> out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace roseau::image
