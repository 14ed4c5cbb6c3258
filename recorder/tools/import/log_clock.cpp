#include "recorder/tools/import/log_clock.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "recorder/tools/import/record_times.h"

namespace roseau::recorder {

namespace {

constexpr double kBlockMillis = 600'000;
constexpr std::size_t kMostInBlock = 4096;
// Further from the others than any wait: a receiver that had the leap seconds wrong, a damaged line.
constexpr Duration kOutlier = std::chrono::milliseconds{1500};
constexpr Duration kHalfDay = std::chrono::hours{12};
constexpr double kLargestDrift = 500e-6;

// More is no time, and nanoseconds must not overflow.
constexpr double kMostMillis = 1e12;  // 30 years
constexpr std::size_t kMostSegments = 10'000;
constexpr Duration kFurthest = std::chrono::days{36'500};

Duration from_millis(double millis) { return Duration{std::llround(std::clamp(millis, -kMostMillis, kMostMillis) * 1e6)}; }

}  // namespace

void LogClock::Steps::add(Duration time) {
  if (entries++ == 0) {
    first = time;
  } else if (time > last) {
    smallest = smallest == Duration{0} ? time - last : std::min(smallest, time - last);
  } else if (time < last) {
    ++back;
    largest_back = std::max(largest_back, last - time);
  }
  last = time;
}

// Counters of 32 bits wrap after 49.7 days; one that falls back by less than half its range is of a logger that started again.
double LogClock::unwrap(std::uint32_t millis, bool& is_new) {
  constexpr double kWrap = 4294967296.0;
  is_new = !last_millis_.has_value();
  if (last_millis_ && millis < *last_millis_) {
    const bool has_wrapped = *last_millis_ - millis > 0x80000000U && wrapped_millis_ < kMostMillis - kWrap;
    wrapped_millis_ = has_wrapped ? wrapped_millis_ + kWrap : 0;
    is_new = !has_wrapped;
    if (is_new) ++segment_;
  }
  last_millis_ = millis;
  return wrapped_millis_ + millis;
}

void LogClock::observe_millis(const LogEntry& entry) {
  bool is_new = false;
  const double millis = unwrap(*entry.millis, is_new);
  ++with_millis_;
  if (is_new && segments_.size() < kMostSegments) {
    finish_block();
    last_gps_.reset();
    segments_.push_back({.begin_millis = millis});
  }
  segments_.back().end_millis = millis;
  if (!entry.gps || !entry.has_fix) return;
  // Only where the GPS time has just changed it is known how old it is: not older than the entry before.
  if (last_gps_ && *last_gps_ != *entry.gps) {
    if (!block_.empty() && (millis - block_.front().millis >= kBlockMillis || block_.size() == kMostInBlock)) finish_block();
    block_.push_back({millis, *entry.gps - from_millis(millis)});
  }
  last_gps_ = entry.gps;
}

// One knot out of what was seen in ten minutes.
void LogClock::finish_block() {
  if (block_.empty()) return;
  auto& knots = segments_.back().knots;
  const bool is_short = block_.back().millis - block_.front().millis < kBlockMillis / 2;
  if (!is_short || knots.empty()) {
    auto sorted = block_;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::ranges::nth_element(sorted, middle, {}, &Knot::offset);
    const Duration limit = middle->offset + kOutlier;
    std::erase_if(block_, [&](const Knot& knot) { return knot.offset > limit; });
    knots.push_back(*std::ranges::max_element(block_, {}, &Knot::offset));
    has_knots_ = true;
  }
  block_.clear();
}

std::optional<Duration> LogClock::stamp_of(const LogEntry& entry) {
  if (!entry.stamp) return std::nullopt;
  if (!entry.stamp->is_time_of_day) return entry.stamp->time;
  if (last_time_of_day_ && entry.stamp->time < *last_time_of_day_ - kHalfDay) days_ += std::chrono::days{1};
  last_time_of_day_ = entry.stamp->time;
  return entry.stamp->time + days_;
}

void LogClock::observe_plain(const LogEntry& entry, std::optional<Duration> sentence_time) {
  if (sentence_time) sentences_.add(*sentence_time);
  const auto stamp = stamp_of(entry);
  if (!stamp) return;
  stamps_.add(*stamp);
  has_time_of_day_ = has_time_of_day_ || entry.stamp->is_time_of_day;
  if (entry.stamp->is_time_of_day && sentence_time && !date_)
    date_ = std::chrono::round<std::chrono::days>(*sentence_time - *stamp);
}

void LogClock::observe(const LogEntry& entry, std::optional<Duration> sentence_time) {
  ++entries_;
  if (entry.millis) observe_millis(entry);
  observe_plain(entry, sentence_time);
}

// Every segment gets a knot: one without GPS follows the one before without a pause, or ends where the next begins.
Result<void> LogClock::settle_segments(const std::string& source_name) {
  if (segments_.size() == kMostSegments) {
    return Error{ErrorCode::corrupt,
                 fmt::format("{}: its milliseconds go back {} times: are these milliseconds?", source_name, kMostSegments)};
  }
  if (!has_knots_) segments_.front().knots.push_back({});
  for (std::size_t i = 1; i < segments_.size(); ++i) {
    const auto& before = segments_[i - 1];
    if (!segments_[i].knots.empty() || before.knots.empty()) continue;
    const auto end = std::min(before.knots.back().offset + from_millis(before.end_millis), kFurthest);
    segments_[i].knots.push_back({segments_[i].begin_millis, end - from_millis(segments_[i].begin_millis)});
  }
  for (std::size_t i = segments_.size() - 1; i > 0; --i) {
    auto& before = segments_[i - 1];
    if (!before.knots.empty()) continue;
    const auto begin = std::max(segments_[i].knots.front().offset + from_millis(segments_[i].begin_millis), -kFurthest);
    before.knots.push_back({before.end_millis, begin - from_millis(before.end_millis)});
  }
  return {};
}

Result<void> LogClock::settle_plain(std::optional<double> rate_hz, const std::string& source_name) {
  if (stamps_.entries == 0 && sentences_.entries == 0) {
    if (!rate_hz || !(*rate_hz > 0)) {
      return Error{
          ErrorCode::invalid_argument,
          source_name + ": neither the logger nor the instrument tells times, so the rate of its lines must be given in Hz"};
    }
    kind_ = Kind::rate;
    rate_hz_ = *rate_hz;
    return {};
  }
  kind_ = stamps_.entries > 0 ? Kind::stamps : Kind::sentences;
  const auto& steps = kind_ == Kind::stamps ? stamps_ : sentences_;
  if (steps.largest_back > kMostStepBack) {
    return Error{ErrorCode::corrupt,
                 fmt::format("{}: its time goes back by {:.1f} s: the logger's clock was set there, so import "
                             "what lies before and behind as two files",
                             source_name, to_seconds(steps.largest_back))};
  }
  is_civil_ = kind_ == Kind::sentences || !has_time_of_day_ || date_.has_value();
  if (!has_time_of_day_ || kind_ == Kind::sentences) date_ = Duration{0};
  first_time_ = *steps.first + date_.value_or(Duration{0});
  resolution_ = steps.smallest;
  return {};
}

Result<void> LogClock::settle(std::optional<double> rate_hz, const std::string& source_name) {
  finish_block();
  if (with_millis_ > 0) {
    if (auto settled = settle_segments(source_name); !settled) return settled;
    kind_ = has_knots_ ? Kind::gps : Kind::millis;
    is_civil_ = has_knots_;
  } else if (auto settled = settle_plain(rate_hz, source_name); !settled) {
    return settled;
  }
  begin_pass();
  if (with_millis_ > 0) {
    LogEntry first;
    first.millis = static_cast<std::uint32_t>(std::fmod(segments_.front().begin_millis, 4294967296.0));
    first_time_ = time_of(first, std::nullopt);
    begin_pass();
  }
  return {};
}

void LogClock::begin_pass() {
  entries_ = 0;
  last_millis_.reset();
  wrapped_millis_ = 0;
  segment_ = 0;
  last_time_of_day_.reset();
  days_ = Duration{0};
  last_plain_.reset();
  last_given_.reset();
}

Duration LogClock::time_of(const LogEntry& entry, std::optional<Duration> sentence_time) {
  Duration time = last_plain_.value_or(first_time_);
  switch (kind_) {
    case Kind::gps:
    case Kind::millis: {
      bool is_new = false;
      if (!entry.millis) break;
      const double millis = unwrap(*entry.millis, is_new);
      time = on_gps(segments_.at(segment_), millis);
      break;
    }
    case Kind::stamps:
      if (const auto stamp = stamp_of(entry)) time = *stamp + date_.value_or(Duration{0});
      break;
    case Kind::sentences:
      if (sentence_time) time = *sentence_time;
      break;
    case Kind::rate:
      time = from_seconds(static_cast<double>(entries_) / rate_hz_);
      break;
    case Kind::none:
      ROSEAU_CHECK(false);
  }
  ++entries_;
  time = last_given_ ? std::max(time, *last_given_) : time;
  last_plain_ = time;
  last_given_ = time;
  return time;
}

Duration LogClock::on_gps(const Segment& segment, double millis) {
  const auto& knots = segment.knots;
  const auto after = std::ranges::upper_bound(knots, millis, {}, &Knot::millis);
  // Outside the knots the drift is that of the whole.
  const bool is_outside = after == knots.begin() || after == knots.end();
  const auto& from = is_outside ? knots.front() : *std::prev(after);
  const auto& to = is_outside ? knots.back() : *after;
  const auto& nearest = after == knots.begin() ? knots.front() : *std::prev(after);
  double drift = 0;
  if (to.millis > from.millis)
    drift = static_cast<double>((to.offset - from.offset).count()) * 1e-6 / (to.millis - from.millis);
  drift = std::clamp(drift, -kLargestDrift, kLargestDrift);
  return nearest.offset + from_millis(millis + drift * (millis - nearest.millis));
}

std::vector<std::string> LogClock::remarks() const {
  std::vector<std::string> remarks;
  switch (kind_) {
    case Kind::gps:
      remarks.push_back(
          fmt::format("times: the logger's milliseconds laid on GPS time (UTC) by {} comparisons; a line's time is "
                      "taken as the arrival of its first byte, and GPS seconds as current when they first appear",
                      segments_.front().knots.size()));
      break;
    case Kind::millis:
      remarks.emplace_back("times: the logger's milliseconds; no GPS fix, so the civil time is not known");
      break;
    case Kind::stamps:
      remarks.push_back(fmt::format("times: the logger's, taken as UTC, in steps of {:g} s{}", to_seconds(resolution_),
                                    has_time_of_day_ && !is_civil_ ? "; times of day without a date" : ""));
      break;
    case Kind::sentences:
      remarks.emplace_back("times: of the sentences ZDA and RMC (UTC); what follows one is spread evenly up to the next");
      break;
    case Kind::rate:
      remarks.emplace_back("times: none; lines evenly spaced at the rate");
      break;
    case Kind::none:
      break;
  }
  if (segments_.size() > 1) remarks.push_back(fmt::format("the logger started {} times", segments_.size()));
  const auto& steps = kind_ == Kind::sentences ? sentences_ : stamps_;
  if ((kind_ == Kind::stamps || kind_ == Kind::sentences) && steps.back > 0)
    remarks.push_back(fmt::format("its clock stepped back {} times, by {:.3f} s at most: held there", steps.back,
                                  to_seconds(steps.largest_back)));
  return remarks;
}

}  // namespace roseau::recorder
