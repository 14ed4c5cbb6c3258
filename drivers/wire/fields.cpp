#include "drivers/wire/fields.h"

#include <algorithm>
#include <charconv>
#include <numeric>

#include "core/sample.h"

namespace roseau::wire {

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::optional<unsigned> hex_digit(char c) {
  if (is_digit(c)) return static_cast<unsigned>(c - '0');
  if (c >= 'A' && c <= 'F') return static_cast<unsigned>(c - 'A') + 10U;
  if (c >= 'a' && c <= 'f') return static_cast<unsigned>(c - 'a') + 10U;
  return std::nullopt;
}

// Three or more nines before the point and only nines behind it.
bool says_nothing(std::string_view digits) {
  return digits.starts_with("999") && digits.find_first_not_of("9.") == std::string_view::npos;
}

std::string_view without_spaces_in_front(std::string_view text) {
  return text.substr(std::min(text.find_first_not_of(' '), text.size()));
}

}  // namespace

std::uint8_t xor_of(std::string_view text) {
  return std::accumulate(text.begin(), text.end(), std::uint8_t{0}, [](std::uint8_t sum, char c) {
    return static_cast<std::uint8_t>(sum ^ static_cast<std::uint8_t>(c));
  });
}

std::optional<std::uint8_t> parse_hex_byte(std::string_view digits) {
  if (digits.size() != 2) return std::nullopt;
  const auto high = hex_digit(digits[0]);
  const auto low = hex_digit(digits[1]);
  if (!high || !low) return std::nullopt;
  return static_cast<std::uint8_t>(*high << 4U | *low);
}

std::string hex_byte(std::uint8_t value) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  return {kDigits[value >> 4U], kDigits[value & 0xFU]};
}

std::vector<std::string_view> split_fields(std::string_view text) {
  std::vector<std::string_view> fields;
  while (true) {
    const auto comma = text.find(',');
    fields.push_back(text.substr(0, comma));
    if (comma == std::string_view::npos) return fields;
    text.remove_prefix(comma + 1);
  }
}

std::optional<double> parse_number(std::string_view field) {
  field = without_spaces_in_front(field);
  if (field.empty()) return kNotMeasured;
  const bool is_negative = field.front() == '-';
  if (is_negative || field.front() == '+') field = without_spaces_in_front(field.substr(1));
  // from_chars takes more than a sonic may send.
  const bool is_plain = !field.empty() && std::ranges::all_of(field, [](char c) { return is_digit(c) || c == '.'; });
  if (!is_plain) return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc{} || end != field.data() + field.size()) return std::nullopt;
  if (says_nothing(field)) return kNotMeasured;
  return is_negative ? -value : value;
}

std::optional<double> mps_per_unit(char unit) {
  switch (unit) {
    case 'M':
      return 1.0;
    case 'N':
      return 1852.0 / 3600.0;
    case 'P':
      return 1609.344 / 3600.0;
    case 'K':
      return 1000.0 / 3600.0;
    case 'F':
      return 0.3048 / 60.0;
    default:
      return std::nullopt;
  }
}

}  // namespace roseau::wire
