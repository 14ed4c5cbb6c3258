// The inner loops of the PNG encoder, in vector code for the CPU at hand (Highway picks it at run time). The results do not
// depend on the CPU.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace roseau::image {

/// No code word is longer: four of them and the bits of an unfinished byte fit into 64 bits.
inline constexpr std::uint8_t kLongestWord_bits = 14;

/// Code words of the 256 byte values, first bit lowest.
struct ByteCode {
  std::array<std::uint32_t, 256> words{};  // (word << 8) | length in bits
};

/// Where the bits go: what is complete is in memory, the last `count` bits (less than 8) are in `bits`.
struct BitSink {
  std::uint8_t* out = nullptr;
  std::uint64_t bits = 0;
  std::uint32_t count = 0;
};

/// PNG's filter 3 on one row of `size` bytes: filtered = row - (left + above) / 2, byte by byte, where left is `step` bytes
/// (one pixel) before and outside of the picture all is 0. `above` null: the first row.
void filter_average(const std::uint8_t* row, const std::uint8_t* above, std::size_t step, std::size_t size,
                    std::uint8_t* filtered);

/// Adds the numbers of times that each value occurs.
void count_bytes(const std::uint8_t* bytes, std::size_t size, std::array<std::uint32_t, 256>& counts);

/// Appends the code words of `size` bytes. Memory: kLongestWord_bits per byte, and 8 bytes more, are written to.
void append_words(const std::uint8_t* bytes, std::size_t size, const ByteCode& code, BitSink& sink);

/// mono16 <-> PNG's byte order.
void swap_bytes_of_pairs(const std::uint8_t* from, std::size_t pairs, std::uint8_t* to);
/// rgb8 <-> bgr8.
void swap_ends_of_triples(const std::uint8_t* from, std::size_t triples, std::uint8_t* to);

}  // namespace roseau::image
