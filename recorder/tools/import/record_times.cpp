#include "recorder/tools/import/record_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace roseau::recorder {

namespace {

constexpr double kFastestRate_hz = 1e6;

// Takes a whole number of `digits` digits and the character behind it.
bool take_number(std::string_view& text, std::size_t digits, std::string_view ends, int& value) {
  if (text.size() < digits) return false;
  const auto [end, error] = std::from_chars(text.data(), text.data() + digits, value);
  if (error != std::errc{} || end != text.data() + digits || value < 0) return false;
  text.remove_prefix(digits);
  if (ends.empty() || text.empty()) return ends.empty();
  if (ends.find(text.front()) == std::string_view::npos) return false;
  text.remove_prefix(1);
  return true;
}

// ".05" -> 50 ms; no fraction is 0.
std::optional<Duration> parse_fraction(std::string_view text) {
  if (text.empty()) return Duration{0};
  if (text.front() != '.' && text.front() != ',') return std::nullopt;
  Duration::rep fraction_ns = 0;
  Duration::rep unit_ns = 100'000'000;
  for (const char c : text.substr(1)) {
    if (c < '0' || c > '9') return std::nullopt;
    fraction_ns += unit_ns * (c - '0');
    unit_ns /= 10;
  }
  return Duration{fraction_ns};
}

std::optional<Duration> parse_seconds(std::string_view text) {
  double seconds = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  constexpr double kMost_s = 4e9;  // differences in nanoseconds must fit
  if (error != std::errc{} || end != text.data() + text.size() || !(std::abs(seconds) < kMost_s)) return std::nullopt;
  return from_seconds(seconds);
}

// The usual interval between neighbours; 0 where there is none.
Duration typical_interval(const std::vector<Duration>& stamps) {
  std::vector<Duration> intervals;
  for (std::size_t i = 1; i < stamps.size(); ++i) intervals.push_back(stamps[i] - stamps[i - 1]);
  if (intervals.empty()) return Duration{0};
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::ranges::nth_element(intervals, middle);
  return *middle;
}

// Stamps are rounded, so the mean over all rows that follow each other closely is better than any one interval.
double rate_of(const std::vector<Duration>& stamps) {
  const double typical_s = to_seconds(typical_interval(stamps));
  if (typical_s <= 0) return 0;
  double steps = 0;
  for (std::size_t i = 1; i < stamps.size(); ++i) steps += std::round(to_seconds(stamps[i] - stamps[i - 1]) / typical_s);
  const double span_s = to_seconds(stamps.back() - stamps.front());
  const double mean_hz = steps / span_s;
  // A rate that people set on an instrument is a whole number of hertz, or of seconds. Stamps are rounded, often to 1 ms.
  const double nice_hz = mean_hz >= 1 ? std::round(mean_hz) : 1 / std::round(1 / mean_hz);
  const double tolerance = 1e-3 + 1e-3 / span_s;
  return std::abs(nice_hz / mean_hz - 1) < tolerance ? nice_hz : mean_hz;
}

Result<RecordTimes> place_by_rate(std::size_t row_count, double rate_hz) {
  RecordTimes times{.rate_hz = rate_hz};
  times.since_first.reserve(row_count);
  for (std::size_t i = 0; i < row_count; ++i) times.since_first.push_back(from_seconds(static_cast<double>(i) / rate_hz));
  return times;
}

// Of stamps that all differ.
Result<RecordTimes> place_by_stamps(const std::vector<Duration>& stamps, std::optional<double> rate_hz,
                                    const std::string& source_name) {
  RecordTimes times{.rate_hz = rate_hz.value_or(stamps.size() > 1 ? rate_of(stamps) : 1.0)};
  times.since_first.reserve(stamps.size());
  double previous_place = -1;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const double place = std::round(to_seconds(stamps[i] - stamps.front()) * times.rate_hz);
    if (place <= previous_place && rate_hz) {
      return Error{ErrorCode::invalid_argument,
                   fmt::format("{}: rows {} and {} are closer together than {} Hz: give the rate that its times tell, or none",
                               source_name, i, i + 1, *rate_hz)};
    }
    if (place <= previous_place) {
      // Too irregular for a grid: the stamps are the times.
      times.missing_rows = 0;
      times.since_first.resize(stamps.size());
      std::ranges::transform(stamps, times.since_first.begin(), [&](Duration stamp) { return stamp - stamps.front(); });
      return times;
    }
    times.missing_rows += static_cast<std::size_t>(place - previous_place - 1);
    times.since_first.push_back(from_seconds(place / times.rate_hz));
    previous_place = place;
  }
  return times;
}

}  // namespace

std::optional<Duration> parse_time_stamp(std::string_view text) {
  if (text.find('-', 1) == std::string_view::npos || text.find(':') == std::string_view::npos) return parse_seconds(text);
  if (text.ends_with('Z')) text.remove_suffix(1);
  int year = 0;
  int month = 0;
  int day = 0;
  int hour = 0;
  int minute = 0;
  int second = 0;
  if (!take_number(text, 4, "-", year) || !take_number(text, 2, "-", month) || !take_number(text, 2, " T", day) ||
      !take_number(text, 2, ":", hour) || !take_number(text, 2, "", minute)) {
    return std::nullopt;
  }
  if (text.starts_with(':')) {
    text.remove_prefix(1);
    if (!take_number(text, 2, "", second)) return std::nullopt;
  }
  const std::chrono::year_month_day date{std::chrono::year{year}, std::chrono::month{static_cast<unsigned>(month)},
                                         std::chrono::day{static_cast<unsigned>(day)}};
  const auto fraction = parse_fraction(text);
  constexpr int kLastHour = 24;                          // loggers end a day with 24:00
  const bool is_our_time = year >= 1900 && year < 2090;  // as for seconds
  if (!date.ok() || !is_our_time || hour > kLastHour || minute > 59 || second > 60 || !fraction) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch() + std::chrono::hours{hour} + std::chrono::minutes{minute} +
         std::chrono::seconds{second} + *fraction;
}

std::string format_time_stamp(Duration since_1970) {
  const auto days = std::chrono::floor<std::chrono::days>(since_1970);
  const std::chrono::year_month_day date{std::chrono::sys_days(days)};
  const std::chrono::hh_mm_ss time{std::chrono::floor<std::chrono::milliseconds>(since_1970 - days)};
  return fmt::format("{:04d}-{:02d}-{:02d}T{:02d}:{:02d}:{:02d}.{:03d}", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), time.hours().count(),
                     time.minutes().count(), time.seconds().count(), time.subseconds().count());
}

Result<RecordTimes> place_records(std::size_t row_count, const std::vector<Duration>& stamps, std::optional<double> rate_hz,
                                  const std::string& source_name) {
  ROSEAU_CHECK(stamps.empty() || stamps.size() == row_count);
  if (rate_hz && !(*rate_hz > 0 && *rate_hz < kFastestRate_hz)) {
    return Error{ErrorCode::invalid_argument, fmt::format("{}: a rate of {} Hz makes no sense", source_name, *rate_hz)};
  }
  if (stamps.empty()) {
    if (rate_hz) return place_by_rate(row_count, *rate_hz);
    return Error{ErrorCode::invalid_argument, source_name + ": no column with times, so the rate must be given in Hz"};
  }
  if (!std::ranges::is_sorted(stamps)) {
    const auto back = std::ranges::is_sorted_until(stamps);
    return Error{ErrorCode::corrupt, fmt::format("{}: the time goes back at row {}", source_name, back - stamps.begin() + 1)};
  }
  // Stamps of whole seconds on a fast record: the rows themselves are all there is to go by.
  if (std::ranges::adjacent_find(stamps) != stamps.end()) {
    if (rate_hz) return place_by_rate(row_count, *rate_hz);
    return Error{ErrorCode::invalid_argument, source_name + ": its times are too coarse to tell the rate: give it in Hz"};
  }
  return place_by_stamps(stamps, rate_hz, source_name);
}

}  // namespace roseau::recorder
