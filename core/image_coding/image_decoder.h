// ImageDecoder: PNG and JPEG files in memory -> pixels. Ours and those of other programs.
//
// Grey and RGB PNG files without interlacing go a fast way of our own; libspng reads all others, and transparency is left
// aside. JPEG: libjpeg-turbo, with the same result on every CPU.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/image_coding/pixel_view.h"

namespace roseau::image {

/// What a coded picture says of itself.
struct CodedInfo {
  ImageStorage coding = ImageStorage::png;  // png or jpeg
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  PixelFormat format = PixelFormat::mono8;  // what decode() gives unless told otherwise: mono8, mono16 or rgb8

  std::size_t row_bytes() const { return width * bytes_per_pixel(format); }
  std::size_t pixel_bytes() const { return row_bytes() * height; }
};

/// Reads the first bytes only. Errors: unsupported (neither PNG nor JPEG, or one with pixels that roseau has no format for),
/// corrupt (no picture, or one of more than kMostPixelBytes).
Result<CodedInfo> read_info(std::span<const std::byte> coded);

/// One per thread. Keeps its memory, which is in proportion to the largest picture so far; a file that declares more pixels
/// than its bytes could stand for is refused before anything is allocated for it.
class ImageDecoder {
 public:
  ImageDecoder();
  ~ImageDecoder();
  ImageDecoder(const ImageDecoder&) = delete;
  ImageDecoder& operator=(const ImageDecoder&) = delete;

  /// Pixels without gaps between the rows into `out`, which must have room for them (read_info). `wanted`: bgr8 where the
  /// picture is rgb8; anything else that differs from what the picture holds is an error. Errors leave `out` undefined: corrupt
  /// (checksums that do not match and files that end too early included), unsupported, invalid_argument.
  Result<CodedInfo> decode(std::span<const std::byte> coded, std::span<std::byte> out,
                           std::optional<PixelFormat> wanted = std::nullopt);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace roseau::image
