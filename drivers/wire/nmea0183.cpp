#include "drivers/wire/nmea0183.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>

#include "core/wind_geometry.h"
#include "drivers/wire/fields.h"
#include "drivers/wire/wind_fields.h"
#include "drivers/wire/wind_sonic.h"

namespace roseau::wire {

namespace {

using Fields = std::vector<std::string_view>;

struct SourceName {
  NmeaWindSource source;
  std::string_view name;
  std::string_view kind;
};
constexpr std::array kSources = {SourceName{NmeaWindSource::mwv_relative, "mwv_r", "MWV"},
                                 SourceName{NmeaWindSource::mwv_true, "mwv_t", "MWV"},
                                 SourceName{NmeaWindSource::mda, "mda", "MDA"}, SourceName{NmeaWindSource::xdr, "xdr", "XDR"}};

const SourceName& entry_of(NmeaWindSource source) {
  const auto* found = std::ranges::find(kSources, source, &SourceName::source);
  ROSEAU_CHECK(found != kSources.end());
  return *found;
}

// MWV and XDR say statute miles with S, where Gill says P.
std::optional<double> nmea_mps_per_unit(std::string_view unit) {
  if (unit.size() != 1) return std::nullopt;
  if (unit == "S") return mps_per_unit('P');
  return unit == "F" || unit == "P" ? std::nullopt : mps_per_unit(unit.front());
}

// Angle and speed to components; NaN where either is empty.
std::optional<WindSample> wind_from_polar(double angle_deg, double speed_mps, double north_offset_deg) {
  if (angle_deg < 0 || angle_deg > 360 || speed_mps < 0 || !is_plausible_wind(speed_mps)) return std::nullopt;
  if (speed_mps == 0) return WindSample{.u_mps = 0, .v_mps = 0};
  if (std::isnan(angle_deg) || std::isnan(speed_mps)) return without_values(0);
  const Vec2 wind = wind_components_mps(speed_mps, angle_deg, north_offset_deg);
  return WindSample{.u_mps = wind.x, .v_mps = wind.y};
}

// Unsigned, as angles and speeds are.
std::optional<double> parse_unsigned(std::string_view field) {
  if (is_signed(field)) return std::nullopt;
  return parse_number(field);
}

std::optional<WindSample> parse_mwv(const Fields& fields) {
  if (fields.size() != 6) return std::nullopt;
  const auto angle_deg = parse_unsigned(fields[1]);
  const auto speed = parse_unsigned(fields[3]);
  const bool is_void = fields[5] == "V";
  const auto unit_mps = fields[4].empty() && is_void ? std::optional(1.0) : nmea_mps_per_unit(fields[4]);
  if (!angle_deg || !speed || !unit_mps || (!is_void && fields[5] != "A")) return std::nullopt;
  auto wind = wind_from_polar(*angle_deg, *speed * *unit_mps, 0);
  if (wind && is_void) return without_values(kNmeaStatusVoid);
  return wind;
}

std::optional<WindSample> parse_xdr_wind(std::string_view body) {
  const auto xdr = parse_nmea_xdr(body);
  if (!xdr) return std::nullopt;
  struct Both {
    double angle_deg = 0;
    double speed_mps = 0;
  };
  std::vector<Both> winds;
  for (const auto& angle : xdr->transducers) {
    if (angle.type != 'A' || angle.unit != 'D') continue;
    for (const auto& speed : xdr->transducers) {
      const auto unit_mps = nmea_mps_per_unit({&speed.unit, 1});
      if (speed.type == 'S' && speed.name == angle.name && unit_mps) winds.push_back({angle.value, speed.value * *unit_mps});
    }
  }
  if (winds.empty()) return std::nullopt;
  const auto& wind = winds[winds.size() == 3 ? 1 : 0];
  return wind_from_polar(wind.angle_deg, wind.speed_mps, 0);
}

bool holds_xdr_wind(const Fields& fields) {
  bool has_angle = false;
  bool has_speed = false;
  for (std::size_t i = 1; i + 2 < fields.size(); i += 4) {
    has_angle = has_angle || (fields[i] == "A" && fields[i + 2] == "D");
    has_speed = has_speed || fields[i] == "S";
  }
  return has_angle && has_speed;
}

std::optional<int> parse_digits(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_whole = !text.empty() && error == std::errc{} && end == text.data() + text.size() && text.front() != '-';
  return is_whole ? std::optional(value) : std::nullopt;
}

// "hhmmss.sss"
std::optional<Duration> parse_time_of_day(std::string_view text) {
  if (text.size() < 6) return std::nullopt;
  const auto hours = parse_digits(text.substr(0, 2));
  const auto minutes = parse_digits(text.substr(2, 2));
  const double seconds = parse_unsigned(text.substr(4)).value_or(kNotMeasured);
  if (!hours || !minutes || *hours > 23 || *minutes > 59 || !(seconds < 61)) return std::nullopt;
  return std::chrono::hours{*hours} + std::chrono::minutes{*minutes} + from_seconds(seconds);
}

std::optional<Duration> since_1970(std::optional<int> year, std::optional<int> month, std::optional<int> day,
                                   std::optional<Duration> time_of_day) {
  if (!year || !month || !day || !time_of_day || *year < 1970 || *year > 2200) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year{*year}, std::chrono::month{static_cast<unsigned>(*month)},
                                         std::chrono::day{static_cast<unsigned>(*day)}};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch() + *time_of_day;
}

std::string print(double value, int decimals) { return std::isnan(value) ? "" : fmt::format("{:.{}f}", value, decimals); }

}  // namespace

std::string nmea_sentence(std::string_view body) { return fmt::format("${}*{}\r\n", body, hex_byte(xor_of(body))); }

std::optional<std::string_view> nmea_body(std::string_view sentence, bool requires_checksum) {
  if (sentence.empty() || sentence.front() != '$' || sentence.size() > kLongestSentence) return std::nullopt;
  sentence.remove_prefix(1);
  const auto star = sentence.find('*');
  const auto body = sentence.substr(0, star);
  if (star == std::string_view::npos) return requires_checksum ? std::nullopt : std::optional(body);
  const auto printed = parse_hex_byte(sentence.substr(star + 1));
  return printed && *printed == xor_of(body) ? std::optional(body) : std::nullopt;
}

std::string_view nmea_kind(std::string_view body) {
  const auto address = body.substr(0, body.find(','));
  const bool is_standard = address.size() == 5 && address.front() != 'P' && std::ranges::all_of(address, [](char c) {
                             return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
                           });
  return is_standard ? address.substr(2) : std::string_view();
}

std::string_view to_string(NmeaWindSource source) { return entry_of(source).name; }

Result<NmeaWindSource> nmea_wind_source_from_string(std::string_view name) {
  const auto* found = std::ranges::find(kSources, name, &SourceName::name);
  if (found != kSources.end()) return found->source;
  return Error{ErrorCode::invalid_argument, fmt::format("sentence '{}' is not known: mwv_r, mwv_t, mda, xdr", name)};
}

std::optional<NmeaXdr> parse_nmea_xdr(std::string_view body) {
  const auto fields = split_fields(body);
  if (nmea_kind(body) != "XDR" || fields.size() < 5 || fields.size() % 4 != 1) return std::nullopt;
  NmeaXdr xdr;
  for (std::size_t i = 1; i < fields.size(); i += 4) {
    const auto value = parse_number(fields[i + 1]);
    if (fields[i].size() != 1 || !value || fields[i + 2].size() > 1) return std::nullopt;
    const char unit = fields[i + 2].empty() ? '\0' : fields[i + 2].front();
    xdr.transducers.push_back({fields[i].front(), *value, unit, std::string(fields[i + 3])});
  }
  return xdr;
}

std::optional<NmeaWeather> parse_nmea_mda(std::string_view body) {
  constexpr std::size_t kFields = 21;
  // Every value is followed by its unit; a missing value may leave that empty too.
  constexpr std::array<std::string_view, kFields> kUnits = {"", "",  "I", "",  "B", "",  "C", "",  "C", "", "",
                                                            "", "C", "",  "T", "",  "M", "",  "N", "",  "M"};
  const auto fields = split_fields(body);
  if (nmea_kind(body) != "MDA" || fields.size() != kFields) return std::nullopt;
  std::array<double, kFields> values{};
  for (std::size_t i = 1; i < kFields; ++i) {
    if (!kUnits[i].empty()) {
      if (fields[i] != kUnits[i] && !fields[i].empty()) return std::nullopt;
      continue;
    }
    const auto value = parse_number(fields[i]);
    if (!value) return std::nullopt;
    values.at(i) = *value;
  }
  constexpr double kHectopascalPerBar = 1000;
  const double wind_mps = std::isnan(values[19]) ? values[17] * *mps_per_unit('N') : values[19];
  return NmeaWeather{.pressure_hpa = values[3] * kHectopascalPerBar,
                     .air_temperature_celsius = values[5],
                     .relative_humidity_percent = values[9],
                     .wind_from_true_deg = values[13],
                     .wind_mps = wind_mps};
}

bool is_foreign_to_nmea_wind(std::string_view body, NmeaWindSource source) {
  if (nmea_kind(body) != entry_of(source).kind) return true;
  const auto fields = split_fields(body);
  if (source == NmeaWindSource::xdr) return !holds_xdr_wind(fields);
  if (source == NmeaWindSource::mda || fields.size() < 3) return false;
  return fields[2] == (source == NmeaWindSource::mwv_relative ? "T" : "R");
}

std::optional<WindSample> parse_nmea_wind(std::string_view body, NmeaWindSource source) {
  if (nmea_kind(body) != entry_of(source).kind) return std::nullopt;
  if (source == NmeaWindSource::xdr) return parse_xdr_wind(body);
  if (source == NmeaWindSource::mda) {
    const auto weather = parse_nmea_mda(body);
    return weather ? wind_from_polar(weather->wind_from_true_deg, weather->wind_mps, 0) : std::nullopt;
  }
  const auto fields = split_fields(body);
  if (fields.size() < 3 || fields[2] != (source == NmeaWindSource::mwv_relative ? "R" : "T")) return std::nullopt;
  return parse_mwv(fields);
}

std::optional<Duration> parse_nmea_time(std::string_view body) {
  const auto fields = split_fields(body);
  if (nmea_kind(body) == "ZDA" && fields.size() == 7)
    return since_1970(parse_digits(fields[4]), parse_digits(fields[3]), parse_digits(fields[2]), parse_time_of_day(fields[1]));
  if (nmea_kind(body) != "RMC" || fields.size() < 10 || fields[2] != "A" || fields[9].size() != 6) return std::nullopt;
  auto year = parse_digits(fields[9].substr(4, 2));
  if (year) *year += *year < 80 ? 2000 : 1900;
  return since_1970(year, parse_digits(fields[9].substr(2, 2)), parse_digits(fields[9].substr(0, 2)),
                    parse_time_of_day(fields[1]));
}

std::string encode_nmea_wind(const WindSample& sample, NmeaWindSource source, std::string_view talker) {
  const bool has_wind = sample.valid && std::isfinite(sample.u_mps) && std::isfinite(sample.v_mps);
  const Polar polar = has_wind ? polar_from_components(sample.u_mps, sample.v_mps) : Polar{kNotMeasured, kNotMeasured};
  const double angle_deg = polar.direction_deg >= 359.95 ? 0 : polar.direction_deg;
  const auto angle = print(angle_deg, 1);
  const auto speed = print(polar.speed, 2);
  switch (source) {
    case NmeaWindSource::mda:
      return nmea_sentence(fmt::format("{}MDA,,I,,B,,C,,C,,,,C,{},T,,M,,N,{},M", talker, angle, speed));
    case NmeaWindSource::xdr:
      return nmea_sentence(fmt::format("{}XDR,A,{},D,1,S,{},M,1", talker, angle, speed));
    case NmeaWindSource::mwv_relative:
    case NmeaWindSource::mwv_true:
      break;
  }
  const char reference = source == NmeaWindSource::mwv_true ? 'T' : 'R';
  return nmea_sentence(fmt::format("{}MWV,{},{},{},M,{}", talker, angle, reference, speed, has_wind ? 'A' : 'V'));
}

std::string encode_nmea_zda(Duration since_1970, std::string_view talker) {
  const auto days = std::chrono::floor<std::chrono::days>(since_1970);
  const std::chrono::year_month_day date{std::chrono::sys_days(days)};
  const std::chrono::hh_mm_ss time{std::chrono::floor<std::chrono::milliseconds>(since_1970 - days)};
  return nmea_sentence(fmt::format("{}ZDA,{:02d}{:02d}{:02d}.{:03d},{:02d},{:02d},{:04d},00,00", talker, time.hours().count(),
                                   time.minutes().count(), time.seconds().count(), time.subseconds().count(),
                                   static_cast<unsigned>(date.day()), static_cast<unsigned>(date.month()),
                                   static_cast<int>(date.year())));
}

}  // namespace roseau::wire
