// Writes small uncompressed AVI files, right ones and wrong ones, so that tests know every pixel.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace roseau::testing {

struct RawAvi {
  std::uint32_t width = 8;
  std::uint32_t height = 4;
  std::uint32_t rate_hz = 10;
  std::uint32_t announced_frames = 0;
  /// One chunk per frame time: rows from the top, 3 bytes (blue, green, red) per pixel. An empty one means that no picture
  /// was taken at that time.
  std::vector<std::string> chunks;

  /// A picture of one colour.
  std::string plain(char blue, char green, char red) const {
    std::string picture;
    for (std::uint32_t i = 0; i < width * height; ++i) picture += {blue, green, red};
    return picture;
  }

  std::string bytes() const {
    const std::string header = list(
        "hdrl", chunk("avih", main_header()) + list("strl", chunk("strh", stream_header()) + chunk("strf", bitmap_header())));
    std::string movie;
    std::string index;
    for (const auto& picture : chunks) {
      index += "00db" + u32(0x10) + u32(static_cast<std::uint32_t>(4 + movie.size())) +
               u32(static_cast<std::uint32_t>(picture.size()));
      movie += chunk("00db", bottom_up(picture));
    }
    return chunk("RIFF", "AVI " + header + list("movi", movie) + chunk("idx1", index));
  }

 private:
  static std::string u32(std::uint32_t value) {
    std::string text;
    for (unsigned shift = 0; shift < 32; shift += 8) text += static_cast<char>(value >> shift & 0xFFU);
    return text;
  }
  static std::string u16(std::uint32_t value) { return u32(value).substr(0, 2); }
  static std::string chunk(std::string_view name, std::string_view content) {
    std::string text = std::string(name) + u32(static_cast<std::uint32_t>(content.size()));
    text += content;
    if (content.size() % 2 != 0) text += '\0';
    return text;
  }
  static std::string list(std::string_view name, const std::string& content) {
    return chunk("LIST", std::string(name) + content);
  }

  std::string main_header() const {
    constexpr std::uint32_t kHasIndex = 0x10;
    return u32(1'000'000 / rate_hz) + u32(0) + u32(0) + u32(kHasIndex) + u32(announced_frames) + u32(0) + u32(1) +
           u32(width * height * 3) + u32(width) + u32(height) + std::string(16, '\0');
  }
  std::string stream_header() const {
    return "vidsDIB " + u32(0) + u32(0) + u32(0) + u32(1) + u32(rate_hz) + u32(0) + u32(announced_frames) +
           u32(width * height * 3) + u32(0xFFFFFFFF) + u32(0) + u16(0) + u16(0) + u16(width) + u16(height);
  }
  std::string bitmap_header() const {
    return u32(40) + u32(width) + u32(height) + u16(1) + u16(24) + u32(0) + u32(width * height * 3) + std::string(16, '\0');
  }
  std::string bottom_up(const std::string& picture) const {
    std::string turned;
    for (std::size_t row = height; row-- > 0 && !picture.empty();)
      turned += picture.substr(row * width * 3, std::size_t{width} * 3);
    return turned;
  }
};

}  // namespace roseau::testing
