#include "core/image_coding/png_kernels.h"

#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/image_coding/png_kernels.cpp"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace roseau::image::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Bytes = hn::ScalableTag<std::uint8_t>;

void filter_average_of_row(const std::uint8_t* HWY_RESTRICT row, const std::uint8_t* HWY_RESTRICT above, std::size_t step,
                           std::size_t size, std::uint8_t* HWY_RESTRICT filtered) {
  const Bytes d;
  const auto above_at = [above](std::size_t i) { return above == nullptr ? 0U : above[i]; };
  std::size_t i = 0;
  for (; i < step && i < size; ++i) filtered[i] = static_cast<std::uint8_t>(row[i] - above_at(i) / 2);
  for (; i + hn::Lanes(d) <= size; i += hn::Lanes(d)) {
    const auto left = hn::LoadU(d, row + i - step);
    const auto up = above == nullptr ? hn::Zero(d) : hn::LoadU(d, above + i);
    // The CPU's mean of two bytes rounds up.
    const auto odd = hn::And(hn::Xor(left, up), hn::Set(d, 1));
    const auto mean = hn::Sub(hn::AverageRound(left, up), odd);
    hn::StoreU(hn::Sub(hn::LoadU(d, row + i), mean), d, filtered + i);
  }
  for (; i < size; ++i) filtered[i] = static_cast<std::uint8_t>(row[i] - (row[i - step] + above_at(i)) / 2);
}

void append_words_of_bytes(const std::uint8_t* HWY_RESTRICT bytes, std::size_t size, const ByteCode& code, BitSink& sink) {
  const std::uint32_t* HWY_RESTRICT words = code.words.data();
  std::uint8_t* HWY_RESTRICT out = sink.out;
  std::uint64_t bits = sink.bits;
  std::uint64_t count = sink.count;
  std::size_t i = 0;
  for (; i + 4 <= size; i += 4) {
    const std::uint64_t a = words[bytes[i]];
    const std::uint64_t b = words[bytes[i + 1]];
    const std::uint64_t c = words[bytes[i + 2]];
    const std::uint64_t d = words[bytes[i + 3]];
    // A shift looks at its count's lowest six bits only, and lengths stand there: no masking, and the sums of three lengths
    // and of the whole stay below 64.
    const std::uint64_t first = (a >> 8U) | ((b >> 8U) << (a & 63U));
    const std::uint64_t second = (c >> 8U) | ((d >> 8U) << (c & 63U));
    const std::uint64_t first_count = (a + b) & 63U;
    bits |= (first | (second << first_count)) << count;
    count += (a + b + c + d) & 63U;
    std::memcpy(out, &bits, sizeof(bits));
    out += count >> 3U;
    bits >>= count & 56U;
    count &= 7U;
  }
  for (; i < size; ++i) {
    const std::uint64_t word = words[bytes[i]];
    bits |= (word >> 8U) << count;
    count += word & 63U;
    std::memcpy(out, &bits, sizeof(bits));
    out += count >> 3U;
    bits >>= count & 56U;
    count &= 7U;
  }
  sink = {out, bits, static_cast<std::uint32_t>(count)};
}

void swap_bytes_of_all_pairs(const std::uint8_t* HWY_RESTRICT from, std::size_t pairs, std::uint8_t* HWY_RESTRICT to) {
  for (std::size_t i = 0; i < pairs; ++i) {
    std::uint16_t pair = 0;
    std::memcpy(&pair, from + 2 * i, sizeof(pair));
    pair = static_cast<std::uint16_t>((pair << 8U) | (pair >> 8U));
    std::memcpy(to + 2 * i, &pair, sizeof(pair));
  }
}

void swap_ends_of_all_triples(const std::uint8_t* HWY_RESTRICT from, std::size_t triples, std::uint8_t* HWY_RESTRICT to) {
  const Bytes d;
  using V = hn::Vec<Bytes>;
  std::size_t i = 0;
  for (; i + hn::Lanes(d) <= triples; i += hn::Lanes(d)) {
    V first;
    V middle;
    V last;
    hn::LoadInterleaved3(d, from + 3 * i, first, middle, last);
    hn::StoreInterleaved3(last, middle, first, d, to + 3 * i);
  }
  for (; i < triples; ++i) {
    to[3 * i] = from[3 * i + 2];
    to[3 * i + 1] = from[3 * i + 1];
    to[3 * i + 2] = from[3 * i];
  }
}

}  // namespace
}  // namespace roseau::image::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace roseau::image {

HWY_EXPORT(filter_average_of_row);
HWY_EXPORT(append_words_of_bytes);
HWY_EXPORT(swap_bytes_of_all_pairs);
HWY_EXPORT(swap_ends_of_all_triples);

void filter_average(const std::uint8_t* row, const std::uint8_t* above, std::size_t step, std::size_t size,
                    std::uint8_t* filtered) {
  HWY_DYNAMIC_DISPATCH(filter_average_of_row)(row, above, step, size, filtered);
}

void count_bytes(const std::uint8_t* bytes, std::size_t size, std::array<std::uint32_t, 256>& counts) {
  // Four tables: a CPU cannot add to the number that it has just added to without waiting for it.
  std::array<std::array<std::uint32_t, 256>, 4> partial{};
  std::size_t i = 0;
  for (; i + 4 <= size; i += 4) {
    for (std::size_t lane = 0; lane < 4; ++lane) ++partial[lane][bytes[i + lane]];
  }
  for (; i < size; ++i) ++partial[0][bytes[i]];
  for (std::size_t value = 0; value < counts.size(); ++value) {
    for (const auto& lane : partial) counts[value] += lane[value];
  }
}

void append_words(const std::uint8_t* bytes, std::size_t size, const ByteCode& code, BitSink& sink) {
  HWY_DYNAMIC_DISPATCH(append_words_of_bytes)(bytes, size, code, sink);
}

void swap_bytes_of_pairs(const std::uint8_t* from, std::size_t pairs, std::uint8_t* to) {
  HWY_DYNAMIC_DISPATCH(swap_bytes_of_all_pairs)(from, pairs, to);
}

void swap_ends_of_triples(const std::uint8_t* from, std::size_t triples, std::uint8_t* to) {
  HWY_DYNAMIC_DISPATCH(swap_ends_of_all_triples)(from, triples, to);
}

}  // namespace roseau::image
#endif
