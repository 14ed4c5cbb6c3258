#include "recorder/tools/selection/civil_time.h"

#include <fmt/format.h>

#include <charconv>
#include <chrono>

namespace roseau::recorder {

namespace {

constexpr std::int64_t kNanosPerSecond = 1'000'000'000;

/// A number of exactly so many digits, and the character behind it if that must be one.
bool take(std::string_view& text, std::size_t digits, int& value) {
  if (text.size() < digits) return false;
  const auto [end, error] = std::from_chars(text.data(), text.data() + digits, value);
  if (error != std::errc{} || end != text.data() + digits || text.front() == '-') return false;
  text.remove_prefix(digits);
  return true;
}

bool take(std::string_view& text, char wanted) {
  if (text.empty() || text.front() != wanted) return false;
  text.remove_prefix(1);
  return true;
}

std::optional<std::int64_t> take_fraction(std::string_view& text) {
  if (!take(text, '.') && !take(text, ',')) return 0;
  std::int64_t fraction_ns = 0;
  std::int64_t unit_ns = kNanosPerSecond / 10;
  std::size_t digits = 0;
  for (; digits < text.size() && text[digits] >= '0' && text[digits] <= '9'; ++digits) {
    fraction_ns += unit_ns * (text[digits] - '0');
    unit_ns /= 10;
  }
  text.remove_prefix(digits);
  if (digits == 0) return std::nullopt;
  return fraction_ns;
}

/// Seconds that local time is ahead of UTC.
std::optional<int> take_zone(std::string_view& text) {
  if (text.empty() || take(text, 'Z') || take(text, 'z')) return 0;
  const int sign = text.front() == '-' ? -1 : 1;
  if (!take(text, '+') && !take(text, '-')) return std::nullopt;
  int hours = 0;
  int minutes = 0;
  if (!take(text, 2, hours)) return std::nullopt;
  take(text, ':');
  if (!text.empty() && !take(text, 2, minutes)) return std::nullopt;
  if (hours > 23 || minutes > 59) return std::nullopt;
  return sign * (hours * 3600 + minutes * 60);
}

}  // namespace

std::string utc_text(std::int64_t utc_ns, int digits, char separator, std::string_view zone) {
  const std::chrono::sys_time<std::chrono::nanoseconds> time{std::chrono::nanoseconds{utc_ns}};
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date{day};
  const std::chrono::hh_mm_ss clock{time - day};
  std::string text = fmt::format("{:04}-{:02}-{:02}{}{:02}:{:02}:{:02}", static_cast<int>(date.year()),
                                 static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), separator,
                                 clock.hours().count(), clock.minutes().count(), clock.seconds().count());
  if (digits > 0) {
    const std::string fraction = fmt::format("{:09}", clock.subseconds().count());
    text += "." + fraction.substr(0, static_cast<std::size_t>(digits));
  }
  return text.append(zone);
}

std::optional<std::int64_t> parse_utc(std::string_view text) {
  int year = 0;
  int month = 0;
  int day = 0;
  int hour = 0;
  int minute = 0;
  int second = 0;
  if (!take(text, 4, year) || !take(text, '-') || !take(text, 2, month) || !take(text, '-') || !take(text, 2, day)) {
    return std::nullopt;
  }
  if (!text.empty()) {
    if (!take(text, 'T') && !take(text, 't') && !take(text, ' ')) return std::nullopt;
    if (!take(text, 2, hour) || !take(text, ':') || !take(text, 2, minute)) return std::nullopt;
    if (take(text, ':') && !take(text, 2, second)) return std::nullopt;
  }
  const auto fraction_ns = take_fraction(text);
  if (!fraction_ns) return std::nullopt;
  const auto zone_s = take_zone(text);
  const std::chrono::year_month_day date{std::chrono::year{year}, std::chrono::month{static_cast<unsigned>(month)},
                                         std::chrono::day{static_cast<unsigned>(day)}};
  // 64 bits of nanoseconds end in 2262.
  const bool is_a_time = date.ok() && year >= 1700 && year < 2262 && hour <= 24 && minute <= 59 && second <= 60;
  if (!zone_s || !text.empty() || !is_a_time) return std::nullopt;
  const std::int64_t days = std::chrono::sys_days{date}.time_since_epoch().count();
  return (days * 86'400 + hour * 3600 + minute * 60 + second - *zone_s) * kNanosPerSecond + *fraction_ns;
}

}  // namespace roseau::recorder
