#include "drivers/wire/fastrak.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "drivers/wire/fastrak_items.h"
#include "drivers/wire/rotations.h"

namespace roseau::wire {

namespace {

static_assert(std::endian::native == std::endian::little, "floats are copied as they are");

// No receiver reaches further (reference: 200 inches), so what says so is no record.
constexpr double kFurthest_m = 200 * 0.0254;
constexpr double kLargestAngle_deg = 360.5;
constexpr double kMost = 999.99;  // what "Sxxx.xx" holds

bool is_error_letter(char c) { return c == ' ' || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

bool is_number_character(char c, bool is_extended) {
  return (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+' || c == ' ' || (is_extended && c == 'E');
}

std::string_view without_spaces(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

std::optional<double> parse_text_number(std::string_view field, bool is_extended) {
  if (!std::ranges::all_of(field, [&](char c) { return is_number_character(c, is_extended); })) return std::nullopt;
  field = without_spaces(field);
  const bool is_negative = field.starts_with('-');
  if (is_negative || field.starts_with('+')) field = without_spaces(field.substr(1));
  if (field.empty() || field.front() == '-') return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc{} || end != field.data() + field.size()) return std::nullopt;
  return is_negative ? -value : value;
}

double parse_binary_number(std::string_view field) {
  float value = 0;
  std::memcpy(&value, field.data(), sizeof value);
  return value;
}

using Numbers = std::array<double, 4>;

// Numbers of one item; nothing when one of them is none.
std::optional<Numbers> parse_numbers(std::string_view bytes, const FastrakItem& item, bool is_binary) {
  Numbers numbers{};
  const std::size_t width = bytes.size() / std::max<std::size_t>(1, item.numbers);
  for (std::size_t i = 0; i < item.numbers; ++i) {
    const auto field = bytes.substr(i * width, width);
    const auto value = is_binary ? parse_binary_number(field) : parse_text_number(field, item.is_extended);
    if (!value || !std::isfinite(*value)) return std::nullopt;
    numbers[i] = *value;
  }
  return numbers;
}

// Collects a record's items; every take tells whether the item makes sense.
class PoseBuilder {
 public:
  PoseBuilder(std::string_view header, FastrakUnit unit) : unit_m_(metres_per(unit)) {
    pose_.station = static_cast<std::uint8_t>(header[1] - '0');
    if (header[2] != ' ') {
      pose_.device_status = static_cast<std::uint8_t>(header[2]);
      pose_.valid = false;
    }
  }

  bool take(const FastrakItem& item, std::string_view bytes, bool is_binary) {
    const auto numbers = parse_numbers(bytes, item, is_binary);
    if (!numbers) return false;
    switch (item.what) {
      case FastrakItem::What::space:
        return bytes == " ";
      case FastrakItem::What::line_end:
        return bytes == "\r\n";
      case FastrakItem::What::stylus:
        return bytes == "0" || bytes == "1";
      case FastrakItem::What::movement:
        return true;
      case FastrakItem::What::position:
        return take_position(*numbers);
      case FastrakItem::What::angles:
        return take_angles(*numbers);
      case FastrakItem::What::quaternion:
        return take_rotation(normalised({(*numbers)[0], (*numbers)[1], (*numbers)[2], (*numbers)[3]}));
      case FastrakItem::What::cosines_x:
      case FastrakItem::What::cosines_y:
      case FastrakItem::What::cosines_z:
        return take_cosines(static_cast<std::size_t>(item.what) - static_cast<std::size_t>(FastrakItem::What::cosines_x),
                            {(*numbers)[0], (*numbers)[1], (*numbers)[2]});
    }
    return false;
  }

  const StationPose& pose() const { return pose_; }

 private:
  bool take_position(const Numbers& numbers) {
    pose_.position_in_source_m = {numbers[0] * unit_m_, numbers[1] * unit_m_, numbers[2] * unit_m_};
    const Vec3& p = pose_.position_in_source_m;
    return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) < kFurthest_m;
  }
  bool take_angles(const Numbers& numbers) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (std::abs(numbers[i]) > kLargestAngle_deg) return false;
    }
    return take_rotation(quaternion_from_angles_deg(numbers[0], numbers[1], numbers[2]));
  }
  bool take_cosines(std::size_t row, const Vec3& cosines) {
    rows_[row] = cosines;
    has_row_[row] = true;
    if (!has_row_[0] || !has_row_[1] || !has_row_[2]) return true;
    return take_rotation(quaternion_from_matrix(rows_));
  }
  bool take_rotation(const std::optional<Quaternion>& rotation) {
    if (rotation) pose_.source_from_station = *rotation;
    return rotation.has_value();
  }

  StationPose pose_;
  double unit_m_;
  Matrix3 rows_{};
  std::array<bool, 3> has_row_{};
};

std::optional<StationPose> parse_record(std::string_view record, const FastrakLayout& layout, FastrakUnit unit,
                                        bool is_binary) {
  if (record.size() != (is_binary ? layout.binary_bytes() : layout.text_bytes()) || !is_fastrak_header(record)) {
    return std::nullopt;
  }
  PoseBuilder builder(record, unit);
  record.remove_prefix(kFastrakHeaderBytes);
  for (const int code : layout.items()) {
    const auto item = fastrak_item(code);
    const std::size_t size = is_binary ? item->binary_bytes : item->text_bytes;
    if (!builder.take(*item, record.substr(0, size), is_binary)) return std::nullopt;
    record.remove_prefix(size);
  }
  return builder.pose();
}

// -----------------------------------------------------------------------------------------------------------------------

std::string extended_number(double value) {
  // Sx.xxxxxESxxb: fmt prints at least two digits of exponent, and no value of ours needs three.
  return fmt::format("{: .5E} ", value);
}

std::string number_text(double value, const FastrakItem& item, bool is_binary) {
  if (is_binary) {
    const auto single = static_cast<float>(value);
    std::string bytes(sizeof single, '\0');
    std::memcpy(bytes.data(), &single, sizeof single);
    return bytes;
  }
  if (item.is_extended) return extended_number(value);
  return fmt::format("{:7.{}f}", std::clamp(value, -kMost, kMost), item.decimals);
}

Numbers numbers_of(const FastrakItem& item, const StationPose& pose, double unit_m) {
  const Vec3& p = pose.position_in_source_m;
  const Quaternion& q = pose.source_from_station;
  const auto row = [&](std::size_t i) {
    const Vec3 cosines = matrix_from_quaternion(q)[i];
    return Numbers{cosines.x, cosines.y, cosines.z};
  };
  switch (item.what) {
    case FastrakItem::What::position:
      return {p.x / unit_m, p.y / unit_m, p.z / unit_m};
    case FastrakItem::What::angles: {
      const Angles angles = angles_from_quaternion(q);
      return {angles.azimuth_deg, angles.elevation_deg, angles.roll_deg};
    }
    case FastrakItem::What::quaternion:
      return {q.w, q.x, q.y, q.z};
    case FastrakItem::What::cosines_x:
      return row(0);
    case FastrakItem::What::cosines_y:
      return row(1);
    case FastrakItem::What::cosines_z:
      return row(2);
    default:
      return {};
  }
}

}  // namespace

double metres_per(FastrakUnit unit) { return unit == FastrakUnit::inch ? 0.0254 : 0.01; }

bool is_fastrak_header(std::string_view bytes) {
  return bytes.size() >= kFastrakHeaderBytes && bytes[0] == '0' && bytes[1] >= '1' && bytes[1] < '1' + kFastrakStations &&
         is_error_letter(bytes[2]);
}

std::optional<StationPose> parse_fastrak_text(std::string_view record, const FastrakLayout& layout, FastrakUnit unit) {
  return parse_record(record, layout, unit, false);
}

std::optional<StationPose> parse_fastrak_binary(std::string_view record, const FastrakLayout& layout, FastrakUnit unit) {
  return parse_record(record, layout, unit, true);
}

bool may_become_fastrak_text(std::string_view bytes, const FastrakLayout& layout) {
  if (bytes.size() < kFastrakHeaderBytes) return true;
  if (!is_fastrak_header(bytes)) return false;
  bytes.remove_prefix(kFastrakHeaderBytes);
  for (const int code : layout.items()) {
    const auto item = fastrak_item(code);
    const auto part = bytes.substr(0, item->text_bytes);
    const bool fits = item->what == FastrakItem::What::line_end
                          ? std::string_view("\r\n").starts_with(part)
                          : std::ranges::all_of(part, [&](char c) { return is_number_character(c, item->is_extended); });
    if (!fits) return false;
    bytes.remove_prefix(part.size());
    if (bytes.empty()) break;
  }
  return true;
}

std::string encode_fastrak(const StationPose& pose, const FastrakFormat& format) {
  std::string record = "0";
  record += static_cast<char>('0' + pose.station);
  record += pose.device_status == 0 ? ' ' : static_cast<char>(pose.device_status);
  ROSEAU_CHECK(is_fastrak_header(record));
  for (const int code : format.layout.items()) {
    const auto item = fastrak_item(code);
    if (item->what == FastrakItem::What::space) record += ' ';
    if (item->what == FastrakItem::What::line_end) record += "\r\n";
    if (item->what == FastrakItem::What::stylus) record += '0';
    const Numbers numbers = numbers_of(*item, pose, metres_per(format.unit));
    for (std::size_t i = 0; i < item->numbers; ++i) record += number_text(numbers[i], *item, format.is_binary);
  }
  return record;
}

}  // namespace roseau::wire
