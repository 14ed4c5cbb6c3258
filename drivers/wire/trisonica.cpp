#include "drivers/wire/trisonica.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/wind_geometry.h"
#include "drivers/wire/fields.h"
#include "drivers/wire/wind_fields.h"

namespace roseau::wire {

namespace {

constexpr std::size_t kMostDecimals = 9;
// What the instrument puts in place of a value: -99.9, -99.99, ... No wind and no temperature is lower.
constexpr double kNothingBelow = -99;

bool is_tag(std::string_view word) {
  const auto is_letter = [](char c) { return c >= 'A' && c <= 'Z'; };
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (word.empty() || word.size() > 2 || !is_letter(word[0])) return false;
  return word.size() == 1 || is_letter(word[1]) || is_digit(word[1]);
}

std::string_view take_word(std::string_view& rest) {
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  const auto word = rest.substr(0, rest.find(' '));
  rest.remove_prefix(word.size());
  return word;
}

std::size_t decimals_of(std::string_view number) {
  const auto point = number.find('.');
  return point == std::string_view::npos ? 0 : number.size() - point - 1;
}

struct Pair {
  std::string_view tag;
  std::string_view number;
  double value = 0;
};

// Tag and value at the beginning of `rest`; nothing when there are none.
std::optional<Pair> take_pair(std::string_view& rest) {
  Pair pair;
  pair.tag = take_word(rest);
  pair.number = take_word(rest);
  if (!is_tag(pair.tag) || pair.number.empty() || pair.number.front() == '+' || pair.number.back() == '.') return std::nullopt;
  const auto value = parse_number(pair.number);
  if (!value || decimals_of(pair.number) > kMostDecimals) return std::nullopt;
  pair.value = *value;
  return pair;
}

bool is_blank(std::string_view text) { return text.find_first_not_of(' ') == std::string_view::npos; }

double measured(double value) { return value <= kNothingBelow ? kNotMeasured : value; }

// As printed: everything but counters and angles with leading zeros, a column for the sign.
std::string print(const TriSonicaLayout::Item& item, double value) {
  const double shown = std::isnan(value) ? -99.9999999999 : value;
  if (item.tag == "AD" || item.tag == "P") return fmt::format("{} {: .{}f}", item.tag, shown, item.decimals);
  if (item.decimals > 0) return fmt::format("{} {: 0{}.{}f}", item.tag, shown, item.decimals + 4, item.decimals);
  const auto whole = std::llround(std::trunc(shown) == -99 ? -99.0 : shown);
  const bool is_angle = item.tag.ends_with('D') || item.tag == "DV";
  return is_angle ? fmt::format("{} {: 04d}", item.tag, whole) : fmt::format("{}{:7d}", item.tag, whole);
}

}  // namespace

std::optional<TriSonicaLayout> TriSonicaLayout::make(std::vector<Item> items) {
  TriSonicaLayout layout;
  layout.items_ = std::move(items);
  for (std::size_t i = 0; i < layout.items_.size(); ++i) {
    if (layout.find(layout.items_[i].tag) != i) return std::nullopt;
  }
  const bool has_components = layout.find("U") && layout.find("V");
  const bool has_polar = layout.find("S2") && layout.find("D");
  if (layout.items_.size() > kMostItems || (!has_components && !has_polar)) return std::nullopt;
  return layout;
}

Result<TriSonicaLayout> TriSonicaLayout::parse(std::string_view text) {
  std::vector<Item> items;
  for (const auto field : split_fields(text)) {
    const auto colon = field.find(':');
    const auto decimals = colon == std::string_view::npos ? std::string_view() : field.substr(colon + 1);
    const bool is_digit = decimals.size() == 1 && decimals[0] >= '0' && decimals[0] <= '9';
    if (!is_tag(field.substr(0, colon)) || !is_digit) {
      return Error{ErrorCode::invalid_argument,
                   fmt::format("items '{}': '{}' should read TAG:DECIMALS, like U:3", text, field)};
    }
    items.push_back({std::string(field.substr(0, colon)), static_cast<std::size_t>(decimals[0] - '0')});
  }
  if (auto layout = make(std::move(items))) return *layout;
  return Error{ErrorCode::invalid_argument, fmt::format("items '{}': needs U and V, or S2 and D, and each tag once", text)};
}

std::optional<TriSonicaLayout> TriSonicaLayout::of_line(std::string_view line) {
  std::vector<Item> items;
  while (!is_blank(line)) {
    const auto pair = take_pair(line);
    if (!pair || items.size() == kMostItems) return std::nullopt;
    items.push_back({std::string(pair->tag), decimals_of(pair->number)});
  }
  return make(std::move(items));
}

std::string TriSonicaLayout::text() const {
  std::string text;
  for (const auto& item : items_) text += fmt::format("{}{}:{}", text.empty() ? "" : ",", item.tag, item.decimals);
  return text;
}

std::optional<std::size_t> TriSonicaLayout::find(std::string_view tag) const {
  const auto found = std::ranges::find(items_, tag, &Item::tag);
  if (found == items_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - items_.begin());
}

TriSonicaLayout default_trisonica_layout() {
  return TriSonicaLayout::parse("S2:3,D:0,U:3,V:3,W:3,T:2,H:2,AD:7,AX:0,AY:0,AZ:0,MD:0").value();
}

std::optional<std::vector<double>> parse_trisonica(std::string_view line, const TriSonicaLayout& layout) {
  std::vector<double> values;
  values.reserve(layout.items().size());
  for (const auto& item : layout.items()) {
    const auto pair = take_pair(line);
    if (!pair || pair->tag != item.tag || decimals_of(pair->number) != item.decimals) return std::nullopt;
    values.push_back(pair->value);
  }
  if (!is_blank(line)) return std::nullopt;
  return values;
}

std::optional<WindSample> trisonica_wind(const std::vector<double>& values, const TriSonicaLayout& layout) {
  const auto value_of = [&](std::string_view tag) {
    const auto index = layout.find(tag);
    return index ? measured(values[*index]) : kNotMeasured;
  };
  WindSample wind{.u_mps = value_of("U"), .v_mps = value_of("V"), .w_mps = value_of("W")};
  if (!layout.find("U") || !layout.find("V")) {
    const auto components = wind_components_mps(value_of("S2"), value_of("D"), 0, WindAxes::east_north);
    wind.u_mps = components.x;
    wind.v_mps = components.y;
  }
  wind.sonic_temperature_celsius = value_of("T");
  if (!is_plausible_wind(std::hypot(wind.u_mps, wind.v_mps)) || !is_plausible_wind(wind.w_mps)) return std::nullopt;
  wind.valid = std::isfinite(wind.u_mps) && std::isfinite(wind.v_mps) && (!layout.find("W") || std::isfinite(wind.w_mps));
  return wind;
}

std::string encode_trisonica(const WindSample& sample, const TriSonicaLayout& layout,
                             const std::map<std::string, double>& others) {
  const double horizontal_mps = std::hypot(sample.u_mps, sample.v_mps);
  std::map<std::string, double> values = {{"U", sample.u_mps},
                                          {"V", sample.v_mps},
                                          {"W", sample.w_mps},
                                          {"T", sample.sonic_temperature_celsius},
                                          {"S2", horizontal_mps},
                                          {"S", std::hypot(horizontal_mps, sample.w_mps)},
                                          {"D", wind_direction_deg(sample.u_mps, sample.v_mps, 0, WindAxes::east_north)},
                                          {"DV", std::atan2(sample.w_mps, horizontal_mps) * 180 / std::numbers::pi}};
  values.insert(others.begin(), others.end());
  std::string line;
  for (const auto& item : layout.items()) line += (line.empty() ? "" : " ") + print(item, values[item.tag]);
  return line + "\r\n";
}

}  // namespace roseau::wire
