#include "drivers/wire/wind_master.h"

#include <fmt/format.h>

#include <cmath>

#include "drivers/wire/fields.h"
#include "drivers/wire/wind_fields.h"

namespace roseau::wire {

namespace {

using Fields = std::vector<std::string_view>;

constexpr std::uint16_t kLargestGain = 0x0A;
constexpr std::uint16_t kRetriesUsed = 0x0B;
constexpr std::size_t kMostAnalogueInputs = 4;

// Node, three wind fields and unit come first in every record.
constexpr std::size_t kFirstWindField = 1;
constexpr std::size_t kUnitField = 4;
constexpr std::size_t kBehindUnit = 5;

// In air between -100 and 100 degrees Celsius.
bool is_speed_of_sound(double speed_mps) { return speed_mps > 250 && speed_mps < 400; }

// The manual does not say whether the speed of sound follows the wind's unit: only one reading can be one.
std::optional<double> speed_of_sound_mps(std::string_view field, double unit_mps) {
  const auto value = parse_number(field);
  if (!value || std::isnan(*value) || is_speed_of_sound(*value)) return value;
  if (is_speed_of_sound(*value * unit_mps)) return *value * unit_mps;
  return std::nullopt;
}

bool is_analogue_input(std::string_view field) { return is_signed(field) && parse_number(field); }

bool is_platinum_thermometer(std::string_view field) {
  return field.ends_with('C') && parse_number(field.substr(0, field.size() - 1));
}

// Behind the status: analogue inputs, thermometer, and nothing behind the last comma, each there or not.
bool is_plausible_rest(const Fields& fields, std::size_t next) {
  std::size_t inputs = 0;
  while (next < fields.size() && is_analogue_input(fields[next])) {
    ++inputs;
    ++next;
  }
  if (next < fields.size() && is_platinum_thermometer(fields[next])) ++next;
  if (next < fields.size() && fields[next].empty()) ++next;
  return inputs <= kMostAnalogueInputs && next == fields.size();
}

struct Wind {
  Vec2 horizontal;
  double w = 0;
};

std::optional<Wind> parse_wind(const Fields& fields, double unit_mps) {
  const auto horizontal = parse_horizontal_wind(fields[kFirstWindField], fields[kFirstWindField + 1], unit_mps);
  const auto vertical = parse_number(fields[kFirstWindField + 2]);
  if (!horizontal || !vertical || !is_plausible_wind(*vertical * unit_mps)) return std::nullopt;
  return Wind{.horizontal = *horizontal, .w = *vertical * unit_mps};
}

bool has_wind(const WindSample& sample) {
  return sample.valid && std::isfinite(sample.u_mps) && std::isfinite(sample.v_mps) && std::isfinite(sample.w_mps);
}

std::string wind_text(const WindSample& sample, const WindMasterFormat& format, double unit_mps) {
  const bool is_polar = format.mode == WindMasterFormat::Mode::polar;
  const bool is_high = format.high_resolution;
  if (!has_wind(sample)) {
    if (!format.fixed_fields) return ",,";
    if (is_polar) return is_high ? "999.9,999.999,+999.999" : "999,999.99,+999.99";
    return is_high ? "+999.999,+999.999,+999.999" : "+999.99,+999.99,+999.99";
  }
  const double u = sample.u_mps / unit_mps;
  const double v = sample.v_mps / unit_mps;
  const double w = sample.w_mps / unit_mps;
  if (!is_polar)
    return is_high ? fmt::format("{:+08.3f},{:+08.3f},{:+08.3f}", u, v, w)
                   : fmt::format("{:+07.2f},{:+07.2f},{:+07.2f}", u, v, w);
  const Polar polar = polar_from_components(u, v);
  // Rounding may reach 360, which is north again.
  const double steps = is_high ? 10.0 : 1.0;
  const double direction_deg = std::fmod(std::round(polar.direction_deg * steps) / steps, 360.0);
  return is_high ? fmt::format("{:05.1f},{:07.3f},{:+08.3f}", direction_deg, polar.speed, w)
                 : fmt::format("{:03.0f},{:06.2f},{:+07.2f}", direction_deg, polar.speed, w);
}

std::string temperature_text(const WindSample& sample, const WindMasterFormat& format) {
  const auto number = [&](double value) {
    if (std::isfinite(value)) return fmt::format("{:+07.2f}", value);
    return std::string(format.fixed_fields ? "+999.99" : "");
  };
  return number(sample.speed_of_sound_mps) + "," + number(sample.sonic_temperature_celsius) + ",";
}

std::string body_of(const WindSample& sample, const WindMasterFormat& format, double unit_mps) {
  auto body = fmt::format("{},{},{},", format.node, wind_text(sample, format, unit_mps), format.unit);
  if (format.has_temperature) body += temperature_text(sample, format);
  body += hex_byte(static_cast<std::uint8_t>(sample.device_status)) + ",";
  for (const double input : format.analogue_inputs) body += fmt::format("{:+.4f},", input);
  if (format.platinum_celsius) body += fmt::format("{:+06.2f}C,", *format.platinum_celsius);
  return body;
}

}  // namespace

bool wind_master_status_is_good(std::uint16_t status) {
  return status == 0 || status == kLargestGain || status == kRetriesUsed;
}

bool is_foreign_to_wind_master(const GillRecord& record) { return record.is_nmea; }

std::optional<WindSample> parse_wind_master(const GillRecord& record) {
  const auto fields = split_fields(record.body);
  if (fields.size() <= kBehindUnit || fields[0].size() != 1 || fields[kUnitField].size() != 1) {
    return std::nullopt;
  }
  const auto unit_mps = mps_per_unit(fields[kUnitField].front());
  if (!unit_mps) return std::nullopt;

  // Two hexadecimal digits right behind the unit are the status; else speed of sound and temperature stand between.
  std::optional<double> speed_of_sound = kNotMeasured;
  std::optional<double> temperature = kNotMeasured;
  std::size_t status_field = kBehindUnit;
  if (!parse_hex_byte(fields[kBehindUnit])) {
    status_field += 2;
    if (fields.size() <= status_field) return std::nullopt;
    speed_of_sound = speed_of_sound_mps(fields[kBehindUnit], *unit_mps);
    temperature = parse_number(fields[kBehindUnit + 1]);
  }
  const auto status = parse_hex_byte(fields[status_field]);
  const auto wind = parse_wind(fields, *unit_mps);
  if (!status || !wind || !speed_of_sound || !temperature || !is_plausible_rest(fields, status_field + 1)) return std::nullopt;

  const bool is_measured = !std::isnan(wind->horizontal.x) && !std::isnan(wind->horizontal.y) && !std::isnan(wind->w);
  if (!wind_master_status_is_good(*status) || !is_measured) return without_values(*status);
  return WindSample{.u_mps = wind->horizontal.x,
                    .v_mps = wind->horizontal.y,
                    .w_mps = wind->w,
                    .sonic_temperature_celsius = *temperature,
                    .speed_of_sound_mps = *speed_of_sound,
                    .device_status = *status};
}

std::vector<std::byte> encode_wind_master(const WindSample& sample, const WindMasterFormat& format) {
  const auto unit_mps = mps_per_unit(format.unit);
  ROSEAU_CHECK(unit_mps.has_value() && format.analogue_inputs.size() <= kMostAnalogueInputs);
  const auto body = body_of(sample, format, *unit_mps);
  const std::string_view terminator = format.ends_with_line ? "\r\n" : "";
  return to_bytes(format.is_delimited ? delimited(body, terminator) : body + std::string(terminator));
}

}  // namespace roseau::wire
