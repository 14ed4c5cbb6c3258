#include "drivers/wire/wind_sonic.h"

#include <fmt/format.h>

#include <cmath>

#include "drivers/wire/fields.h"
#include "drivers/wire/wind_fields.h"

namespace roseau::wire {

namespace {

using Fields = std::vector<std::string_view>;

constexpr std::uint16_t kLargestGain = 0x10;

std::optional<WindSample> sample_from(std::string_view first, std::string_view second, double unit_mps, std::uint16_t status) {
  const auto wind = parse_horizontal_wind(first, second, unit_mps);
  if (!wind) return std::nullopt;
  if (!wind_sonic_status_is_good(status) || std::isnan(wind->x) || std::isnan(wind->y)) return without_values(status);
  return WindSample{.u_mps = wind->x, .v_mps = wind->y, .device_status = status};
}

// Q,<first>,<second>,<unit>,<status>[,]
std::optional<WindSample> parse_gill(const Fields& fields) {
  const bool ends_with_comma = fields.size() == 6 && fields[5].empty();
  if ((fields.size() != 5 && !ends_with_comma) || fields[0].size() != 1 || fields[3].size() != 1) return std::nullopt;
  const auto unit_mps = mps_per_unit(fields[3].front());
  const auto status = parse_hex_byte(fields[4]);
  if (!unit_mps || !status) return std::nullopt;
  return sample_from(fields[1], fields[2], *unit_mps, *status);
}

std::optional<std::uint16_t> parse_nmea_status(std::string_view field) {
  if (field == "A") return std::uint16_t{0};
  if (field == "V") return kNmeaStatusVoid;
  return parse_hex_byte(field);
}

// WIMWV,<direction>,R,<speed>,<unit>,<status>
std::optional<WindSample> parse_nmea(const Fields& fields) {
  if (fields.size() != 6 || fields[0].size() != 5 || fields[0].substr(2) != "MWV" || fields[2] != "R" || fields[4].size() > 1) {
    return std::nullopt;
  }
  const auto status = parse_nmea_status(fields[5]);
  // With an error some firmware leaves the unit empty too.
  const auto unit_mps = mps_per_unit(fields[4].empty() ? 'M' : fields[4].front());
  if (!unit_mps || !status) return std::nullopt;
  return sample_from(fields[1], fields[3], *unit_mps, *status);
}

bool has_wind(const WindSample& sample) { return sample.valid && std::isfinite(sample.u_mps) && std::isfinite(sample.v_mps); }

// Direction and speed as the polar and NMEA records print them.
struct PolarText {
  std::string direction;
  std::string speed;
};

PolarText polar_text(const WindSample& sample, const WindSonicFormat& format, double unit_mps) {
  if (!has_wind(sample)) return format.fixed_fields ? PolarText{"999", "999.99"} : PolarText{};
  const Polar polar = polar_from_components(sample.u_mps, sample.v_mps);
  const bool is_calm = polar.speed < format.calm_below_mps && !format.fixed_fields;
  const auto direction = static_cast<int>(std::lround(polar.direction_deg)) % 360;
  return {is_calm ? std::string() : fmt::format("{:03d}", direction), fmt::format("{:06.2f}", polar.speed / unit_mps)};
}

std::string nmea_record(const WindSample& sample, const WindSonicFormat& format, double unit_mps) {
  const PolarText polar = polar_text(sample, format, unit_mps);
  const std::string status =
      format.nmea_status_is_gill ? hex_byte(static_cast<std::uint8_t>(sample.device_status)) : (has_wind(sample) ? "A" : "V");
  const auto body = fmt::format("{}MWV,{},R,{},{},{}", format.nmea_talker, polar.direction, polar.speed, format.unit, status);
  return fmt::format("${}*{}", body, hex_byte(xor_of(body)));
}

std::string gill_body(const WindSample& sample, const WindSonicFormat& format, double unit_mps) {
  std::string first;
  std::string second;
  if (format.mode == WindSonicFormat::Mode::polar) {
    const PolarText polar = polar_text(sample, format, unit_mps);
    first = polar.direction;
    second = polar.speed;
  } else if (has_wind(sample)) {
    first = fmt::format("{:+07.2f}", sample.u_mps / unit_mps);
    second = fmt::format("{:+07.2f}", sample.v_mps / unit_mps);
  } else if (format.fixed_fields) {
    first = "+999.99";
    second = "+999.99";
  }
  return fmt::format("{},{},{},{},{},", format.node, first, second, format.unit,
                     hex_byte(static_cast<std::uint8_t>(sample.device_status)));
}

}  // namespace

bool wind_sonic_status_is_good(std::uint16_t status) { return status == 0 || status == kLargestGain; }

bool is_foreign_to_wind_sonic(const GillRecord& record) {
  if (!record.is_nmea) return false;
  const auto fields = split_fields(record.body);
  return fields[0].size() != 5 || fields[0].substr(2) != "MWV" || (fields.size() > 2 && fields[2] == "T");
}

std::optional<WindSample> parse_wind_sonic(const GillRecord& record) {
  const auto fields = split_fields(record.body);
  return record.is_nmea ? parse_nmea(fields) : parse_gill(fields);
}

std::vector<std::byte> encode_wind_sonic(const WindSample& sample, const WindSonicFormat& format) {
  const auto unit_mps = mps_per_unit(format.unit);
  ROSEAU_CHECK(unit_mps.has_value());
  const std::string_view terminator = format.ends_with_line_feed ? "\r\n" : "\r";
  if (format.mode == WindSonicFormat::Mode::nmea) {
    return to_bytes(nmea_record(sample, format, *unit_mps) + std::string(terminator));
  }
  return to_bytes(delimited(gill_body(sample, format, *unit_mps), terminator));
}

}  // namespace roseau::wire
