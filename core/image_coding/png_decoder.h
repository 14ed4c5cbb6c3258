// PNG files -> pixels, for ImageDecoder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "core/image_coding/image_decoder.h"

namespace roseau::image {

bool is_png(std::span<const std::byte> coded);
Result<CodedInfo> read_png_info(std::span<const std::byte> coded);

class PngDecoder {
 public:
  PngDecoder();
  ~PngDecoder();
  PngDecoder(const PngDecoder&) = delete;
  PngDecoder& operator=(const PngDecoder&) = delete;
  /// `info` is the file's; `out` has exactly its pixels' size.
  Result<void> decode(std::span<const std::byte> coded, const CodedInfo& info, std::span<std::byte> out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace roseau::image
