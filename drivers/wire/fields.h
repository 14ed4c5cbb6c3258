// The pieces that Gill's and NMEA's text records are made of: comma-separated fields, numbers, units, XOR checksums.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace roseau::wire {

/// XOR of all bytes.
std::uint8_t xor_of(std::string_view text);

/// Two hexadecimal digits of either case; nothing for anything else.
std::optional<std::uint8_t> parse_hex_byte(std::string_view digits);

/// Two upper-case digits, as the instruments print them.
std::string hex_byte(std::uint8_t value);

std::vector<std::string_view> split_fields(std::string_view text);

/// A plain decimal number, with the spaces that some firmware leaves before it and behind its sign. NaN when the field is
/// empty or full of nines ("999", "+999.99": the instrument had nothing to say); nothing when it is no number at all
/// (exponents, "nan" and "inf" are none).
std::optional<double> parse_number(std::string_view field);

/// Metres per second in one of Gill's wind speed units: M m/s, N knots, P miles per hour, K km/h, F feet per minute.
std::optional<double> mps_per_unit(char unit);

}  // namespace roseau::wire
