// JPEG by libjpeg-turbo. Encoder and decoder use the exact transform, whose result does not depend on the CPU.
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
  /// `quality` from 1 to 100.
  explicit JpegEncoder(int quality);
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

/// For ImageDecoder.
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
