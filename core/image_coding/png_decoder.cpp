#include "core/image_coding/png_decoder.h"

#include <libdeflate.h>
#include <spng.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "core/check.h"
#include "core/image_coding/png_format.h"
#include "core/image_coding/png_kernels.h"

namespace roseau::image {

namespace {

using png::bytes_of;
using png::get_be32;
using png::kChunkFrame_bytes;
using Bytes = std::span<const std::uint8_t>;

// Deflate codes at most 258 bytes with two bits.
constexpr std::size_t kMostInflation = 1032;

Error corrupt(const std::string& what) { return {ErrorCode::corrupt, "PNG: " + what}; }

struct Header {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint8_t depth = 0;
  std::uint8_t colour = 0;
  std::uint8_t interlace = 0;

  bool is_plain_grey() const { return colour == static_cast<std::uint8_t>(png::Colour::grey) && (depth == 8 || depth == 16); }
  bool is_plain() const {
    const bool is_rgb = colour == static_cast<std::uint8_t>(png::Colour::rgb) && depth == 8;
    return interlace == 0 && (is_plain_grey() || is_rgb);
  }
  /// Of the pixels as they are compressed, at least.
  std::uint64_t raw_bytes() const {
    constexpr std::array<std::uint64_t, 7> kChannels{1, 0, 3, 1, 2, 0, 4};
    const std::uint64_t channels = colour < kChannels.size() ? kChannels[colour] : 0;
    return std::uint64_t{width} * channels * depth / 8 * height;
  }
  PixelFormat format() const {
    if (colour != static_cast<std::uint8_t>(png::Colour::grey)) return PixelFormat::rgb8;
    return depth == 16 ? PixelFormat::mono16 : PixelFormat::mono8;
  }
};

Result<Header> read_header(Bytes file) {
  constexpr std::size_t kBegin = png::kSignature.size() + 8;
  if (file.size() < png::kSignature.size() + png::kHeaderChunk_bytes) return corrupt("the file ends within its header");
  const std::uint8_t* at = file.data() + kBegin;
  if (get_be32(at - 8) != 13 || !std::ranges::equal(std::string_view("IHDR"), Bytes(at - 4, 4), {}, {},
                                                    [](std::uint8_t byte) { return static_cast<char>(byte); })) {
    return corrupt("the file does not begin with its header");
  }
  if (libdeflate_crc32(0, at - 4, 17) != get_be32(at + 13)) return corrupt("the header's checksum is wrong");
  return Header{.width = get_be32(at), .height = get_be32(at + 4), .depth = at[8], .colour = at[9], .interlace = at[12]};
}

/// The pieces of compressed data, every chunk's CRC checked up to the last of them.
Result<std::vector<Bytes>> find_data(Bytes file) {
  std::vector<Bytes> data;
  for (Bytes rest = file.subspan(png::kSignature.size());;) {
    if (rest.size() < kChunkFrame_bytes) return corrupt("the file ends too early");
    const std::size_t size = get_be32(rest.data());
    if (size > rest.size() - kChunkFrame_bytes) return corrupt("a part of the file is longer than the file");
    const std::string_view type(reinterpret_cast<const char*>(rest.data()) + 4, 4);
    if (libdeflate_crc32(0, rest.data() + 4, size + 4) != get_be32(rest.data() + 8 + size)) {
      return corrupt("a checksum is wrong");
    }
    if (type == "IEND") return data;
    if (type == "IDAT") data.push_back(rest.subspan(8, size));
    rest = rest.subspan(size + kChunkFrame_bytes);
  }
}

void unfilter_sub(std::uint8_t* row, std::size_t step, std::size_t size) {
  for (std::size_t i = step; i < size; ++i) row[i] = static_cast<std::uint8_t>(row[i] + row[i - step]);
}

void unfilter_up(std::uint8_t* row, const std::uint8_t* above, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) row[i] = static_cast<std::uint8_t>(row[i] + above[i]);
}

void unfilter_average(std::uint8_t* row, const std::uint8_t* above, std::size_t step, std::size_t size) {
  for (std::size_t i = 0; i < step; ++i) row[i] = static_cast<std::uint8_t>(row[i] + above[i] / 2);
  if (step == 1) {
    unsigned left = row[0];  // in a register: the next pixel needs it at once
    for (std::size_t i = 1; i < size; ++i) {
      left = (row[i] + (left + above[i]) / 2) & 255U;
      row[i] = static_cast<std::uint8_t>(left);
    }
    return;
  }
  for (std::size_t i = step; i < size; ++i) row[i] = static_cast<std::uint8_t>(row[i] + (row[i - step] + above[i]) / 2);
}

int nearest(int left, int above, int corner) {
  const int guess = left + above - corner;
  const int from_left = std::abs(guess - left);
  const int from_above = std::abs(guess - above);
  const int from_corner = std::abs(guess - corner);
  if (from_left <= from_above && from_left <= from_corner) return left;
  return from_above <= from_corner ? above : corner;
}

void unfilter_paeth(std::uint8_t* row, const std::uint8_t* above, std::size_t step, std::size_t size) {
  for (std::size_t i = 0; i < step; ++i) row[i] = static_cast<std::uint8_t>(row[i] + above[i]);
  for (std::size_t i = step; i < size; ++i) {
    row[i] = static_cast<std::uint8_t>(row[i] + nearest(row[i - step], above[i], above[i - step]));
  }
}

bool unfilter(std::uint8_t filter, std::uint8_t* row, const std::uint8_t* above, std::size_t step, std::size_t size) {
  switch (static_cast<png::Filter>(filter)) {
    case png::Filter::none:
      return true;
    case png::Filter::sub:
      unfilter_sub(row, step, size);
      return true;
    case png::Filter::up:
      unfilter_up(row, above, size);
      return true;
    case png::Filter::average:
      unfilter_average(row, above, step, size);
      return true;
    case png::Filter::paeth:
      unfilter_paeth(row, above, step, size);
      return true;
  }
  return false;
}

}  // namespace

bool is_png(std::span<const std::byte> coded) {
  return coded.size() >= png::kSignature.size() && std::memcmp(coded.data(), png::kSignature.data(), 8) == 0;
}

Result<CodedInfo> read_png_info(std::span<const std::byte> coded) {
  const auto header = read_header({bytes_of(coded), coded.size()});
  if (!header) return header.error();
  if (header->width <= png::kLongestSide_px && header->height <= png::kLongestSide_px &&
      header->raw_bytes() / kMostInflation > coded.size()) {
    return corrupt("it declares more pixels than it can hold");
  }
  return CodedInfo{.coding = ImageStorage::png, .width = header->width, .height = header->height, .format = header->format()};
}

struct PngDecoder::State {
  struct Free {
    void operator()(libdeflate_decompressor* decompressor) const { libdeflate_free_decompressor(decompressor); }
    void operator()(spng_ctx* context) const { spng_ctx_free(context); }
  };
  std::unique_ptr<libdeflate_decompressor, Free> inflater{libdeflate_alloc_decompressor()};
  std::vector<std::uint8_t> joined;    // compressed data that came in several pieces
  std::vector<std::uint8_t> filtered;  // filter bytes and rows
  std::vector<std::uint8_t> zeros;     // what is above the first row

  Result<void> decode_plain(Bytes file, const CodedInfo& info, std::span<std::byte> out);
  static Result<void> decode_other(Bytes file, const CodedInfo& info, std::span<std::byte> out);
  Result<void> inflate(Bytes file, std::size_t size);
};

PngDecoder::PngDecoder() : state_(std::make_unique<State>()) { ROSEAU_CHECK(state_->inflater != nullptr); }
PngDecoder::~PngDecoder() = default;

Result<void> PngDecoder::State::inflate(Bytes file, std::size_t size) {
  const auto pieces = find_data(file);
  if (!pieces) return pieces.error();
  Bytes data = pieces->size() == 1 ? pieces->front() : Bytes();
  if (pieces->size() > 1) {
    joined.clear();
    for (const Bytes piece : *pieces) joined.insert(joined.end(), piece.begin(), piece.end());
    data = joined;
  }
  filtered.resize(size);
  if (libdeflate_zlib_decompress(inflater.get(), data.data(), data.size(), filtered.data(), size, nullptr) !=
      LIBDEFLATE_SUCCESS) {
    return corrupt("the compressed data are broken");
  }
  return {};
}

Result<void> PngDecoder::State::decode_plain(Bytes file, const CodedInfo& info, std::span<std::byte> out) {
  const std::size_t row_bytes = info.row_bytes();
  if (auto inflated = inflate(file, (row_bytes + 1) * info.height); !inflated) return inflated;
  zeros.assign(row_bytes, 0);
  const std::uint8_t* above = zeros.data();
  for (std::uint32_t y = 0; y < info.height; ++y) {
    std::uint8_t* row = filtered.data() + (row_bytes + 1) * y + 1;
    if (!unfilter(row[-1], row, above, bytes_per_pixel(info.format), row_bytes)) return corrupt("an unknown filter");
    std::uint8_t* to = bytes_of(out) + row_bytes * y;
    if (info.format == PixelFormat::mono16) {
      swap_bytes_of_pairs(row, info.width, to);
    } else {
      std::copy_n(row, row_bytes, to);
    }
    above = row;
  }
  return {};
}

Result<void> PngDecoder::State::decode_other(Bytes file, const CodedInfo& info, std::span<std::byte> out) {
  if (const auto whole = find_data(file); !whole) return whole.error();  // libspng does not look behind the last pixel
  const std::unique_ptr<spng_ctx, Free> context(spng_ctx_new(0));
  ROSEAU_CHECK(context != nullptr);
  constexpr std::size_t kMostOfOneChunk_bytes = std::size_t{1} << 20U;  // texts, profiles: nothing that we look at
  const auto failed = [](int code) { return corrupt(spng_strerror(code)); };
  if (const int code = spng_set_image_limits(context.get(), png::kLongestSide_px, png::kLongestSide_px)) return failed(code);
  if (const int code = spng_set_chunk_limits(context.get(), kMostOfOneChunk_bytes, kMostOfOneChunk_bytes)) return failed(code);
  if (const int code = spng_set_png_buffer(context.get(), file.data(), file.size())) return failed(code);
  const spng_format format = info.format == PixelFormat::mono16  ? SPNG_FMT_PNG
                             : info.format == PixelFormat::mono8 ? SPNG_FMT_G8
                                                                 : SPNG_FMT_RGB8;
  std::size_t size = 0;
  if (const int code = spng_decoded_image_size(context.get(), format, &size)) return failed(code);
  if (size != out.size()) return corrupt("its pixels do not fill the picture");
  if (const int code = spng_decode_image(context.get(), out.data(), out.size(), format, 0)) return failed(code);
  return {};
}

Result<void> PngDecoder::decode(std::span<const std::byte> coded, const CodedInfo& info, std::span<std::byte> out) {
  ROSEAU_CHECK(out.size() == info.pixel_bytes());
  const Bytes file(bytes_of(coded), coded.size());
  const auto header = read_header(file);
  if (!header) return header.error();
  return header->is_plain() ? state_->decode_plain(file, info, out) : State::decode_other(file, info, out);
}

}  // namespace roseau::image
