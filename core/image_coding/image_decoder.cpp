#include "core/image_coding/image_decoder.h"

#include <algorithm>
#include <string>

#include "core/image_coding/jpeg.h"
#include "core/image_coding/png_decoder.h"
#include "core/image_coding/png_format.h"
#include "core/image_coding/png_kernels.h"

namespace roseau::image {

namespace {

std::string size_text(const CodedInfo& info) { return std::to_string(info.width) + "x" + std::to_string(info.height); }

Result<CodedInfo> checked(Result<CodedInfo> info) {
  if (!info) return info;
  if (info->width == 0 || info->height == 0) return Error{ErrorCode::corrupt, "a picture without pixels"};
  if (info->width > png::kLongestSide_px || info->height > png::kLongestSide_px || info->pixel_bytes() > kMostPixelBytes) {
    return Error{ErrorCode::corrupt, "a picture of " + size_text(*info) + " is larger than any that is read"};
  }
  return info;
}

/// rgb8 <-> bgr8, row by row as the two may not overlap.
void swap_ends(std::span<std::byte> pixels, std::size_t row_bytes, std::vector<std::uint8_t>& row) {
  row.resize(row_bytes);
  for (std::size_t at = 0; at + row_bytes <= pixels.size(); at += row_bytes) {
    std::uint8_t* bytes = png::bytes_of(pixels.subspan(at));
    std::copy_n(bytes, row_bytes, row.data());
    swap_ends_of_triples(row.data(), row_bytes / 3, bytes);
  }
}

}  // namespace

Result<CodedInfo> read_info(std::span<const std::byte> coded) {
  if (is_png(coded)) return checked(read_png_info(coded));
  if (is_jpeg(coded)) return checked(read_jpeg_info(coded));
  return Error{ErrorCode::unsupported, "a picture that is neither PNG nor JPEG"};
}

struct ImageDecoder::State {
  PngDecoder png;
  JpegDecoder jpeg;
  std::vector<std::uint8_t> row;
};

ImageDecoder::ImageDecoder() : state_(std::make_unique<State>()) {}
ImageDecoder::~ImageDecoder() = default;

Result<CodedInfo> ImageDecoder::decode(std::span<const std::byte> coded, std::span<std::byte> out,
                                       std::optional<PixelFormat> wanted) {
  auto info = read_info(coded);
  if (!info) return info;
  const PixelFormat as = wanted.value_or(info->format);
  const bool is_swapped = as == PixelFormat::bgr8 && info->format == PixelFormat::rgb8;
  if (as != info->format && !is_swapped) {
    return Error{ErrorCode::corrupt,
                 "a " + std::string(to_string(info->format)) + " picture in place of " + std::string(to_string(as))};
  }
  if (out.size() < info->pixel_bytes()) {
    return Error{ErrorCode::invalid_argument, "no room for the pixels of a picture of " + size_text(*info)};
  }
  out = out.first(info->pixel_bytes());
  const auto decoded =
      info->coding == ImageStorage::png ? state_->png.decode(coded, *info, out) : state_->jpeg.decode(coded, *info, out);
  if (!decoded) return decoded.error();
  if (is_swapped) swap_ends(out, info->row_bytes(), state_->row);
  info->format = as;
  return info;
}

}  // namespace roseau::image
