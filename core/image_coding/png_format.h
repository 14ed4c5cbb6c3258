// What PNG files are made of (RFC 2083), for the encoder and the decoder.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

#include "core/frame.h"

namespace roseau::image::png {

inline constexpr std::array<std::uint8_t, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
inline constexpr std::size_t kChunkFrame_bytes = 12;  // length and type before a chunk's data, CRC after it
inline constexpr std::size_t kHeaderChunk_bytes = kChunkFrame_bytes + 13;
inline constexpr std::uint32_t kLongestSide_px = 1U << 20U;

enum class Colour : std::uint8_t { grey = 0, rgb = 2 };
enum class Filter : std::uint8_t { none, sub, up, average, paeth };

inline void put_be32(std::uint8_t* at, std::uint32_t value) {
  for (unsigned i = 0; i < 4; ++i) at[i] = static_cast<std::uint8_t>(value >> (24U - 8U * i));
}

inline std::uint32_t get_be32(const std::uint8_t* at) {
  return (std::uint32_t{at[0]} << 24U) | (std::uint32_t{at[1]} << 16U) | (std::uint32_t{at[2]} << 8U) | at[3];
}

inline std::uint8_t* bytes_of(std::span<std::byte> span) { return reinterpret_cast<std::uint8_t*>(span.data()); }
inline const std::uint8_t* bytes_of(std::span<const std::byte> span) {
  return reinterpret_cast<const std::uint8_t*>(span.data());
}

}  // namespace roseau::image::png
