#include "recorder/format/crc32.h"

#include <libdeflate.h>
#include <zlib.h>

namespace roseau::mcap {

std::uint32_t crc32(std::uint32_t before, std::span<const std::byte> bytes) {
  if (bytes.empty()) return before;  // libdeflate starts anew when the pointer is null
  return libdeflate_crc32(before, bytes.data(), bytes.size());
}

std::uint32_t crc32_combine(std::uint32_t crc_a, std::uint32_t crc_b, std::uint64_t size_b) {
  return static_cast<std::uint32_t>(::crc32_combine(crc_a, crc_b, static_cast<z_off_t>(size_b)));
}

}  // namespace roseau::mcap
