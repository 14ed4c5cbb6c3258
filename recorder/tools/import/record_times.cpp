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

double place_on(const RecordGrid& grid, Duration stamp) {
  return std::round(to_seconds(stamp - grid.first_stamp.value_or(stamp)) * grid.rate_hz);
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

void StampSurvey::add(std::optional<Duration> stamp) {
  ++rows_;
  if (!stamp) return;
  ++stamps_;
  if (!first_) {
    first_ = stamp;
  } else {
    add_interval(*stamp - last_);
  }
  last_ = *stamp;
}

void StampSurvey::add_interval(Duration interval) {
  if (interval < Duration{0} && !back_row_) back_row_ = rows_;
  has_equal_ = has_equal_ || interval == Duration{0};
  if (typical_) {
    steps_ += typical_->count() > 0 ? std::round(to_seconds(interval) / to_seconds(*typical_)) : 0;
    return;
  }
  intervals_.push_back(interval);
  if (intervals_.size() == kMostIntervals) settle_typical();
}

// The usual interval between neighbours; 0 where there is none.
void StampSurvey::settle_typical() {
  if (typical_) return;
  auto sorted = intervals_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::ranges::nth_element(sorted, middle);
  typical_ = sorted.empty() ? Duration{0} : *middle;
  if (*typical_ <= Duration{0}) return;
  for (const auto interval : intervals_) steps_ += std::round(to_seconds(interval) / to_seconds(*typical_));
  intervals_.clear();
}

// Stamps are rounded, so the mean over all rows that follow each other closely is better than any one interval.
double StampSurvey::rate_of_stamps() const {
  const double span_s = to_seconds(last_ - *first_);
  if (!(steps_ > 0) || !(span_s > 0)) return 1.0;
  const double mean_hz = steps_ / span_s;
  // A rate that people set on an instrument is a whole number of hertz, or of seconds. Stamps are rounded, often to 1 ms.
  const double nice_hz = mean_hz >= 1 ? std::round(mean_hz) : 1 / std::round(1 / mean_hz);
  const double tolerance = 1e-3 + 1e-3 / span_s;
  return std::abs(nice_hz / mean_hz - 1) < tolerance ? nice_hz : mean_hz;
}

Result<RecordGrid> StampSurvey::finish(std::optional<double> rate_hz, const std::string& source_name) {
  if (rows_ == 0) return Error{ErrorCode::corrupt, source_name + ": no rows"};
  if (rate_hz && !(*rate_hz > 0 && *rate_hz < kFastestRate_hz))
    return Error{ErrorCode::invalid_argument, fmt::format("{}: a rate of {} Hz makes no sense", source_name, *rate_hz)};
  ROSEAU_CHECK(stamps_ == 0 || stamps_ == rows_);
  RecordGrid grid{.rows = rows_, .first_stamp = first_};
  if (stamps_ == 0) {
    if (!rate_hz)
      return Error{ErrorCode::invalid_argument, source_name + ": no column with times, so the rate must be given in Hz"};
    grid.rate_hz = *rate_hz;
    return grid;
  }
  if (back_row_) {
    return Error{
        ErrorCode::corrupt,
        fmt::format("{}: the time goes back at row {}: the logger's clock was set there, so import what lies before and "
                    "behind as two files",
                    source_name, *back_row_)};
  }
  // Stamps of whole seconds on a fast record: the rows themselves are all there is to go by.
  if (has_equal_) {
    if (!rate_hz)
      return Error{ErrorCode::invalid_argument, source_name + ": its times are too coarse to tell the rate: give it in Hz"};
    grid.rate_hz = *rate_hz;
    return grid;
  }
  settle_typical();
  grid.kind = RecordGrid::Kind::by_stamp;
  grid.rate_hz = rate_hz.value_or(rate_of_stamps());
  return grid;
}

void GridCheck::add(Duration stamp) {
  ++row_;
  const double place = place_on(grid_, stamp);
  if (place <= previous_place_ && !collision_) collision_ = row_;
  if (place > previous_place_ + 1) grid_.missing_rows += static_cast<std::uint64_t>(place - previous_place_ - 1);
  previous_place_ = place;
  last_ = stamp;
}

Result<RecordGrid> GridCheck::finish(bool rate_was_given, const std::string& source_name) const {
  if (!collision_) return grid_;
  if (rate_was_given) {
    return Error{ErrorCode::invalid_argument,
                 fmt::format("{}: rows {} and {} are closer together than {} Hz: give the rate that its times tell, or none",
                             source_name, *collision_ - 1, *collision_, grid_.rate_hz)};
  }
  auto grid = grid_;
  grid.kind = RecordGrid::Kind::as_stamped;
  grid.missing_rows = 0;
  const double span_s = to_seconds(last_ - grid.first_stamp.value_or(last_));
  if (span_s > 0) grid.rate_hz = static_cast<double>(row_ - 1) / span_s;
  return grid;
}

Duration RowPlacer::next(std::optional<Duration> stamp) {
  const auto row = row_++;
  if (grid_.kind == RecordGrid::Kind::by_rate) return from_seconds(static_cast<double>(row) / grid_.rate_hz);
  ROSEAU_CHECK(stamp && grid_.first_stamp);
  if (grid_.kind == RecordGrid::Kind::as_stamped) return *stamp - *grid_.first_stamp;
  return from_seconds(place_on(grid_, *stamp) / grid_.rate_hz);
}

}  // namespace roseau::recorder
