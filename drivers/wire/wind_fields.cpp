#include "drivers/wire/wind_fields.h"

#include <span>

#include "core/wind_geometry.h"
#include "drivers/wire/fields.h"

namespace roseau::wire {

namespace {
std::optional<Vec2> components_from_polar(double speed_mps, double direction_deg, bool is_direction_empty) {
  if (std::isnan(speed_mps)) return Vec2{kNotMeasured, kNotMeasured};
  if (speed_mps < 0 || direction_deg < 0 || direction_deg > 360) return std::nullopt;
  if (is_direction_empty) return Vec2{};
  if (std::isnan(direction_deg)) return Vec2{kNotMeasured, kNotMeasured};
  return wind_components_mps(speed_mps, direction_deg, 0);
}
}  // namespace

bool is_signed(std::string_view field) { return field.starts_with('+') || field.starts_with('-'); }

std::optional<Vec2> parse_horizontal_wind(std::string_view first, std::string_view second, double mps_per_unit) {
  const auto a = parse_number(first);
  const auto b = parse_number(second);
  if (!a || !b) return std::nullopt;
  Vec2 wind{*a * mps_per_unit, *b * mps_per_unit};
  if (!is_signed(first) && !is_signed(second)) {
    const auto components = components_from_polar(*b * mps_per_unit, *a, first.empty());
    if (!components) return std::nullopt;
    wind = *components;
  }
  if (!is_plausible_wind(std::hypot(wind.x, wind.y))) return std::nullopt;
  return wind;
}

Polar polar_from_components(double u, double v) { return {std::hypot(u, v), wind_direction_deg(u, v, 0)}; }

WindSample without_values(std::uint16_t device_status) { return {.device_status = device_status, .valid = false}; }

std::string delimited(std::string_view body, std::string_view terminator) {
  std::string record = "\x02";
  record += body;
  record += '\x03';
  record += hex_byte(xor_of(body));
  record += terminator;
  return record;
}

std::vector<std::byte> to_bytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

}  // namespace roseau::wire
