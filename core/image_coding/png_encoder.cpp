#include "core/image_coding/png_encoder.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <string>

#include "core/check.h"
#include "core/image_coding/huffman.h"
#include "core/image_coding/png_format.h"
#include "core/image_coding/png_kernels.h"

namespace roseau::image {

namespace {

using png::bytes_of;
using png::kChunkFrame_bytes;
using png::kHeaderChunk_bytes;

constexpr std::size_t kDataBegin = png::kSignature.size() + kHeaderChunk_bytes + 8;  // of IDAT's contents
constexpr std::size_t kZlibHeader_bytes = 2;
constexpr std::size_t kTail_bytes = 4 /* Adler-32 */ + 4 /* IDAT's CRC */ + kChunkFrame_bytes /* IEND */;
constexpr std::size_t kLongestStored_bytes = 65535;
constexpr std::size_t kStoredHead_bytes = 5;
// The Huffman code's description, and that the bit packing writes eight bytes at a time.
constexpr std::size_t kSlack_bytes = 512;

// The code is made from a part of the rows: more would not make it better, and looking at all takes time.
constexpr std::size_t kBytesForStatistics = std::size_t{1} << 17U;
constexpr std::uint32_t kMostRowStep = 8;
// How much more a byte that was seen counts than one that was not: those need a word too.
constexpr std::uint32_t kSeenWeight = 16;

constexpr std::size_t kSymbols = 257;  // byte values and the end of the block
constexpr std::size_t kEndOfBlock = 256;
constexpr std::uint8_t kLongestLengthWord_bits = 7;
constexpr std::size_t kLengthSymbols = 19;
// The order in which deflate gives the lengths of the lengths' code.
constexpr std::array<std::uint8_t, kLengthSymbols> kLengthOrder{16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                                                11, 4,  12, 3, 13, 2, 14, 1, 15};

void put_bits(BitSink& sink, std::uint64_t bits, std::uint32_t count) {
  sink.bits |= bits << sink.count;
  for (sink.count += count; sink.count >= 8; sink.count -= 8, sink.bits >>= 8U) {
    *sink.out++ = static_cast<std::uint8_t>(sink.bits);
  }
}

void finish_byte(BitSink& sink) {
  if (sink.count > 0) put_bits(sink, 0, 8 - sink.count);
}

struct BlockCode {
  ByteCode bytes;
  std::uint16_t end_word = 0;
  std::array<std::uint8_t, kSymbols> lengths{};
};

BlockCode make_code(const std::array<std::uint32_t, 256>& counts) {
  std::array<std::uint32_t, kSymbols> weights{};
  for (std::size_t i = 0; i < counts.size(); ++i) weights[i] = counts[i] * kSeenWeight + 1;
  weights[kEndOfBlock] = 1;
  BlockCode code;
  optimal_lengths(weights, kLongestWord_bits, code.lengths);
  std::array<std::uint16_t, kSymbols> words{};
  canonical_words(code.lengths, words);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    code.bytes.words[i] = (std::uint32_t{words[i]} << 8U) | code.lengths[i];
  }
  code.end_word = words[kEndOfBlock];
  return code;
}

/// The head of deflate's block: how long the words are. The lengths themselves are written with a code of their own.
void put_code(BitSink& sink, const BlockCode& code) {
  std::array<std::uint8_t, kSymbols + 1> described{};  // the last: no word for any distance, as nothing is repeated
  std::ranges::copy(code.lengths, described.begin());
  std::array<std::uint32_t, kLengthSymbols> weights{};
  for (const std::uint8_t length : described) ++weights.at(length);
  std::array<std::uint8_t, kLengthSymbols> lengths{};
  optimal_lengths(weights, kLongestLengthWord_bits, lengths);
  std::array<std::uint16_t, kLengthSymbols> words{};
  canonical_words(lengths, words);

  put_bits(sink, 0b101, 3);           // last block, own code
  put_bits(sink, kSymbols - 257, 5);  // words of bytes and lengths
  put_bits(sink, 0, 5);               // words of distances, less 1
  put_bits(sink, kLengthSymbols - 4, 4);
  for (const std::uint8_t symbol : kLengthOrder) put_bits(sink, lengths.at(symbol), 3);
  for (const std::uint8_t length : described) put_bits(sink, words.at(length), lengths.at(length));
}

void put_chunk_head(std::uint8_t* at, std::size_t size, const char (&type)[5]) {
  png::put_be32(at, static_cast<std::uint32_t>(size));
  std::copy_n(type, 4, at + 4);
}

/// The CRC behind a chunk's data, over type and data. Returns what comes behind it.
std::uint8_t* put_chunk_crc(std::uint8_t* chunk, std::size_t size) {
  png::put_be32(chunk + 8 + size, libdeflate_crc32(0, chunk + 4, size + 4));
  return chunk + size + kChunkFrame_bytes;
}

/// Signature and header.
void put_head(const PixelView& view, std::uint8_t* out) {
  std::uint8_t* const chunk = std::ranges::copy(png::kSignature, out).out;
  put_chunk_head(chunk, 13, "IHDR");
  png::put_be32(chunk + 8, view.width);
  png::put_be32(chunk + 12, view.height);
  const bool is_grey = view.format == PixelFormat::mono8 || view.format == PixelFormat::mono16;
  chunk[16] = view.format == PixelFormat::mono16 ? 16 : 8;
  chunk[17] = static_cast<std::uint8_t>(is_grey ? png::Colour::grey : png::Colour::rgb);
  std::fill_n(chunk + 18, 3, std::uint8_t{0});  // deflate, PNG's filters, not interlaced
  put_chunk_crc(chunk, 13);
}

void put_zlib_head(std::uint8_t* at) {
  at[0] = 0x78;  // deflate, window of 32 kB
  at[1] = 0x01;  // fastest; makes the two a multiple of 31
}

/// Everything behind the compressed data, which end at `end`. Returns the file's size.
std::size_t put_tail(std::uint8_t* out, std::uint8_t* end, std::uint32_t adler) {
  png::put_be32(end, adler);
  std::uint8_t* const data_chunk = out + kDataBegin - 8;
  const auto data_size = static_cast<std::size_t>(end + 4 - (out + kDataBegin));
  put_chunk_head(data_chunk, data_size, "IDAT");
  std::uint8_t* const last = put_chunk_crc(data_chunk, data_size);
  put_chunk_head(last, 0, "IEND");
  return static_cast<std::size_t>(put_chunk_crc(last, 0) - out);
}

std::size_t deflated_bytes(const PixelView& view) { return (view.row_bytes() + 1) * view.height; }

}  // namespace

std::size_t PngEncoder::stored_bytes(std::uint32_t width, std::uint32_t height, PixelFormat format) {
  const std::size_t contents = deflated_bytes({.width = width, .height = height, .format = format});
  const std::size_t blocks = (contents + kLongestStored_bytes - 1) / kLongestStored_bytes;
  return kDataBegin + kZlibHeader_bytes + contents + blocks * kStoredHead_bytes + kTail_bytes;
}

std::size_t PngEncoder::buffer_bytes(std::uint32_t width, std::uint32_t height, PixelFormat format) {
  return stored_bytes(width, height, format) + 2 * (width * bytes_per_pixel(format) + 1) + kSlack_bytes;
}

Result<std::size_t> PngEncoder::encode(const PixelView& view, std::span<std::byte> out) {
  if (auto checked = check(view); !checked) return checked.error();
  if (view.width > png::kLongestSide_px || view.height > png::kLongestSide_px) {
    return Error{ErrorCode::invalid_argument, "a picture's side is longer than " + std::to_string(png::kLongestSide_px)};
  }
  if (out.size() < buffer_bytes(view.width, view.height, view.format)) {
    return Error{ErrorCode::invalid_argument, "a buffer of " + std::to_string(out.size()) +
                                                  " bytes is too small for a PNG of " + std::to_string(view.width) + "x" +
                                                  std::to_string(view.height)};
  }
  prepare(view);
  put_head(view, bytes_of(out));
  put_zlib_head(bytes_of(out) + kDataBegin);
  const std::size_t most = stored_bytes(view.width, view.height, view.format);
  const std::size_t compressed = compress(view, out, most);
  return compressed > 0 ? compressed : store(view, out);
}

void PngEncoder::prepare(const PixelView& view) {
  filtered_.resize(view.row_bytes() + 1);
  for (Reordered& row : reordered_) {
    row.y = -1;
    row.bytes.resize(view.row_bytes());
  }
}

/// The row's bytes in PNG's order: where they are, or reordered. Valid until the row after the next is asked for.
const std::uint8_t* PngEncoder::row_in_file_order(const PixelView& view, std::uint32_t y) {
  const std::uint8_t* row = bytes_of(view.pixels.subspan(std::size_t{y} * view.stride));
  if (view.format == PixelFormat::mono8 || view.format == PixelFormat::rgb8) return row;
  Reordered& reordered = reordered_.at(y % 2);
  if (reordered.y != y) {
    const auto reorder = view.format == PixelFormat::mono16 ? swap_bytes_of_pairs : swap_ends_of_triples;
    reorder(row, view.width, reordered.bytes.data());
    reordered.y = y;
  }
  return reordered.bytes.data();
}

/// Filter byte and filtered row.
const std::uint8_t* PngEncoder::filtered_row(const PixelView& view, std::uint32_t y) {
  const std::uint8_t* above = y == 0 ? nullptr : row_in_file_order(view, y - 1);
  const std::uint8_t* row = row_in_file_order(view, y);
  filtered_[0] = static_cast<std::uint8_t>(png::Filter::average);
  filter_average(row, above, bytes_per_pixel(view.format), view.row_bytes(), filtered_.data() + 1);
  return filtered_.data();
}

/// 0 when it would take more than `most_bytes`.
std::size_t PngEncoder::compress(const PixelView& view, std::span<std::byte> out, std::size_t most_bytes) {
  const std::size_t row_bytes = view.row_bytes() + 1;
  std::array<std::uint32_t, 256> counts{};
  const auto step =
      static_cast<std::uint32_t>(std::clamp<std::size_t>(row_bytes * view.height / kBytesForStatistics, 1, kMostRowStep));
  for (std::uint32_t y = 0; y < view.height; y += step) count_bytes(filtered_row(view, y), row_bytes, counts);

  const BlockCode code = make_code(counts);
  BitSink sink{.out = bytes_of(out) + kDataBegin + kZlibHeader_bytes};
  put_code(sink, code);
  const std::uint8_t* const end_of_room = bytes_of(out) + out.size();
  std::uint32_t adler = 1;
  for (std::uint32_t y = 0; y < view.height; ++y) {
    const std::size_t room = static_cast<std::size_t>(end_of_room - sink.out);
    if (room < row_bytes * kLongestWord_bits / 8 + kTail_bytes + 16) return 0;
    const std::uint8_t* row = filtered_row(view, y);
    adler = libdeflate_adler32(adler, row, row_bytes);
    append_words(row, row_bytes, code.bytes, sink);
  }
  put_bits(sink, code.end_word, code.lengths[kEndOfBlock]);
  finish_byte(sink);
  const auto size = static_cast<std::size_t>(sink.out - bytes_of(out)) + kTail_bytes;
  return size > most_bytes ? 0 : put_tail(bytes_of(out), sink.out, adler);
}

/// Without filter or compression: blocks of 65535 bytes as they are.
std::size_t PngEncoder::store(const PixelView& view, std::span<std::byte> out) {
  std::uint8_t* at = bytes_of(out) + kDataBegin + kZlibHeader_bytes;
  std::size_t left_in_block = 0;
  std::size_t left = deflated_bytes(view);
  std::uint32_t adler = 1;
  for (std::uint32_t y = 0; y < view.height; ++y) {
    filtered_[0] = static_cast<std::uint8_t>(png::Filter::none);
    std::copy_n(row_in_file_order(view, y), view.row_bytes(), filtered_.data() + 1);
    adler = libdeflate_adler32(adler, filtered_.data(), filtered_.size());
    for (std::span<const std::uint8_t> rest(filtered_); !rest.empty();) {
      if (left_in_block == 0) {
        left_in_block = std::min(left, kLongestStored_bytes);
        at[0] = left == left_in_block ? 1 : 0;  // last block or not
        at[1] = static_cast<std::uint8_t>(left_in_block);
        at[2] = static_cast<std::uint8_t>(left_in_block >> 8U);
        at[3] = static_cast<std::uint8_t>(~at[1]);
        at[4] = static_cast<std::uint8_t>(~at[2]);
        at += kStoredHead_bytes;
      }
      const std::size_t piece = std::min(rest.size(), left_in_block);
      at = std::copy_n(rest.begin(), piece, at);
      rest = rest.subspan(piece);
      left_in_block -= piece;
      left -= piece;
    }
  }
  return put_tail(bytes_of(out), at, adler);
}

}  // namespace roseau::image
