// Reading and writing text through byte streams, for their tests.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <string_view>

#include "drivers/link/byte_stream.h"

namespace roseau::link {

inline std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

/// Reads until `size` bytes are there or the stream fails; gives up after 2 s.
inline std::string read_text(ByteStream& stream, std::size_t size) {
  std::string text;
  std::array<std::byte, 4096> buffer{};
  for (int attempt = 0; attempt < 40 && text.size() < size; ++attempt) {
    const auto received = stream.read(buffer, std::chrono::milliseconds{50});
    EXPECT_TRUE(received) << received.error().message;
    if (!received || received->finished) break;
    text.append(reinterpret_cast<const char*>(buffer.data()), received->size);
  }
  return text;
}

/// Reads until the stream fails; the failure. Gives up after 2 s.
inline Error read_until_error(ByteStream& stream) {
  std::array<std::byte, 4096> buffer{};
  for (int attempt = 0; attempt < 40; ++attempt) {
    const auto received = stream.read(buffer, std::chrono::milliseconds{50});
    if (!received) return received.error();
  }
  return {ErrorCode::timeout, "no error came"};
}

}  // namespace roseau::link
