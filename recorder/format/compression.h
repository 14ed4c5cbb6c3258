// What MCAP chunks may be compressed with: "" (not at all), "zstd" (one frame), "lz4" (one LZ4 frame).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace roseau::mcap {

enum class Compression : std::uint8_t { none, zstd, lz4 };

std::string_view to_string(Compression compression);  // as the file spells it
std::optional<Compression> compression_from_string(std::string_view name);

/// Replaces `out` by the compressed bytes: zstd at level 1, lz4 at its fastest. Not for Compression::none.
Result<void> compress(Compression compression, std::span<const std::byte> bytes, std::vector<std::byte>& out);

/// Replaces `out` by exactly `expected_bytes` decompressed bytes. `expected_bytes` comes from a file and is not believed:
/// memory grows only with what really comes out. Errors: corrupt. Not for Compression::none.
Result<void> decompress(Compression compression, std::span<const std::byte> bytes, std::uint64_t expected_bytes,
                        std::vector<std::byte>& out);

}  // namespace roseau::mcap
