#include "schema/utf8.h"

#include <cstddef>
#include <cstdint>

namespace roseau::schema {

namespace {

bool is_continuation(std::string_view text, std::size_t index) {
  return index < text.size() && (static_cast<std::uint8_t>(text[index]) & 0xC0) == 0x80;
}

/// Length of the well-formed sequence at the front of `text` (not empty), 0 when there is none. The limits on the second
/// byte (Unicode standard, table 3-7) exclude overlong forms, surrogates and what lies above U+10FFFF.
std::size_t sequence_length(std::string_view text) {
  const auto first = static_cast<std::uint8_t>(text[0]);
  if (first < 0x80) return 1;
  if (first < 0xC2 || first > 0xF4 || !is_continuation(text, 1)) return 0;
  if (first < 0xE0) return 2;
  const auto second = static_cast<std::uint8_t>(text[1]);
  if (!is_continuation(text, 2)) return 0;
  if (first < 0xF0) {
    if ((first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F)) return 0;
    return 3;
  }
  if (!is_continuation(text, 3)) return 0;
  if ((first == 0xF0 && second < 0x90) || (first == 0xF4 && second > 0x8F)) return 0;
  return 4;
}

}  // namespace

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = sequence_length(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

std::string to_utf8(std::string_view text) {
  constexpr std::string_view kReplacement = "\xEF\xBF\xBD";
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = sequence_length(text);
    result += length == 0 ? kReplacement : text.substr(0, length);
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return result;
}

}  // namespace roseau::schema
