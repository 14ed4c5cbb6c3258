// CRC-32 (the zlib polynomial), at memory speed through libdeflate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace roseau::mcap {

/// CRC of bytes appended to those with CRC `before` (0: none).
std::uint32_t crc32(std::uint32_t before, std::span<const std::byte> bytes);

/// CRC of A followed by B from the CRCs of both and B's length: pixels are summed once, and serve the chunk's CRC and the data
/// section's.
std::uint32_t crc32_combine(std::uint32_t crc_a, std::uint32_t crc_b, std::uint64_t size_b);

}  // namespace roseau::mcap
