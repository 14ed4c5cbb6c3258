// Any bytes as a picture. What is accepted has the size that it says, and comes back from our PNG bit for bit.
#include <cstdint>
#include <span>
#include <vector>

#include "core/check.h"
#include "core/image_coding/image_decoder.h"
#include "core/image_coding/png_encoder.h"

using namespace roseau;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kMostPixels = std::size_t{1} << 22U;  // so that a run takes no seconds
  const auto file = std::as_bytes(std::span(data, size));
  const auto info = image::read_info(file);
  if (!info || info->pixel_bytes() > kMostPixels) return 0;
  static image::ImageDecoder decoder;
  std::vector<std::byte> pixels(info->pixel_bytes());
  if (!decoder.decode(file, pixels)) return 0;

  static image::PngEncoder encoder;
  const image::PixelView view{pixels, info->width, info->height, static_cast<std::uint32_t>(info->row_bytes()), info->format};
  std::vector<std::byte> coded(image::PngEncoder::buffer_bytes(info->width, info->height, info->format));
  const auto coded_size = encoder.encode(view, coded);
  ROSEAU_CHECK(coded_size && *coded_size <= image::PngEncoder::stored_bytes(info->width, info->height, info->format));
  std::vector<std::byte> again(pixels.size());
  ROSEAU_CHECK(decoder.decode(std::span(coded).first(*coded_size), again));
  ROSEAU_CHECK(again == pixels);
  return 0;
}
