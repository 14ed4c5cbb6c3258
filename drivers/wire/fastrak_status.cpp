#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "drivers/wire/fastrak.h"

namespace roseau::wire {

namespace {

// Bits of the three hexadecimal digits (page 74); bits 4 to 9 are always set.
constexpr unsigned kBinary = 1;
constexpr unsigned kCentimetres = 2;
constexpr unsigned kCompensation = 4;
constexpr unsigned kContinuous = 8;
constexpr unsigned kAlwaysSet = 0x3F0;

constexpr std::size_t kVersionLength = 6;
constexpr std::size_t kIdentificationLength = 32;

std::string padded(std::string text, std::size_t length) {
  text.resize(length, ' ');
  return text;
}

template <class Integer>
std::optional<Integer> parse_integer(std::string_view text, int base) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  Integer value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<FastrakStatus> parse_fastrak_status(std::string_view line) {
  if (line.size() != kFastrakStatusBytes || !line.ends_with("\r\n")) return std::nullopt;
  if (line[0] != '2' || line[1] < '1' || line[1] >= '1' + kFastrakStations || line[2] != 'S') return std::nullopt;
  const auto flags = parse_integer<unsigned>(line.substr(3, 3), 16);
  if (!flags) return std::nullopt;
  const auto error = line.substr(6, 3);
  const bool has_error = error != "   ";
  const auto error_number = has_error ? parse_integer<int>(error, 10) : std::optional(0);
  const auto receivers = line[12] == ' ' ? std::optional(0U) : parse_integer<unsigned>(line.substr(12, 1), 16);
  if (!error_number || !receivers) return std::nullopt;
  return FastrakStatus{.station = line[1] - '0',
                       .is_binary = (*flags & kBinary) != 0,
                       .unit = (*flags & kCentimetres) != 0 ? FastrakUnit::centimetre : FastrakUnit::inch,
                       .is_compensating = (*flags & kCompensation) != 0,
                       .is_continuous = (*flags & kContinuous) != 0,
                       .error = *error_number,
                       .receivers = *receivers,
                       .version = std::string(line.substr(15, kVersionLength)),
                       .identification = std::string(line.substr(21, kIdentificationLength))};
}

std::string encode_fastrak_status(const FastrakStatus& status) {
  unsigned flags = kAlwaysSet;
  if (status.is_binary) flags |= kBinary;
  if (status.unit == FastrakUnit::centimetre) flags |= kCentimetres;
  if (status.is_compensating) flags |= kCompensation;
  if (status.is_continuous) flags |= kContinuous;
  const std::string error = status.error == 0 ? "   " : fmt::format("{:3}", status.error);
  return fmt::format("2{}S{:03X}{} F3{:X}  {}{}\r\n", status.station, flags, error, status.receivers & 0xFU,
                     padded(status.version, kVersionLength), padded(status.identification, kIdentificationLength));
}

std::string encode_fastrak_error(std::string_view command, int error) {
  std::string printable(command);
  std::ranges::replace_if(
      printable, [](char c) { return c < ' ' || c > '~'; }, '.');
  return fmt::format("2 E*ERROR*{}*ERROR* EC{}\r\n", printable, error);
}

}  // namespace roseau::wire
