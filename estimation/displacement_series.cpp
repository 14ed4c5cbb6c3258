#include "estimation/displacement_series.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "estimation/multitaper.h"

namespace roseau::estimation {

namespace {

constexpr std::size_t kHeld = 17;         // samples from which the rate is found
constexpr std::size_t kDifferences = 31;  // and those in which a change of it must show
constexpr double kRateTolerance = 0.15;
constexpr double kRefineTolerance = 0.05;
constexpr double kGridGain = 0.3;         // how fast the grid follows the samples
constexpr double kVerticalSine = 0.2588;  // 15 degrees

double median_ns(std::vector<std::int64_t> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return static_cast<double>(*middle);
}

}  // namespace

void DisplacementSeries::note_difference(std::int64_t difference_ns) {
  if (differences_ns_.size() >= kDifferences) differences_ns_.erase(differences_ns_.begin());
  differences_ns_.push_back(difference_ns);
}

bool DisplacementSeries::rate_has_changed() const {
  if (period_s_ == 0 || differences_ns_.size() < kDifferences) return false;
  return std::abs(median_ns(differences_ns_) * 1e-9 / period_s_ - 1) > kRateTolerance;
}

void DisplacementSeries::append(std::int64_t time_ns, Vec2 at, bool measured) {
  frames_.push_back({time_ns, at, measured});
  ++segment_frames_;
  ++appended_;
}

DisplacementSeries::Added DisplacementSeries::add(HostTime time, Vec2 at) {
  appended_ = 0;
  const std::int64_t time_ns = to_ns(time);
  if (seen_ns_ && time_ns <= *seen_ns_) return Added::nothing;
  if (seen_ns_) note_difference(time_ns - *seen_ns_);
  seen_ns_ = time_ns;
  if (rate_has_changed()) {
    period_s_ = 0;
    differences_ns_.clear();
  }
  return period_s_ == 0 ? hold(time_ns, at) : place(time_ns, at);
}

// The median of a few differences is the period, whatever holes there are between them.
DisplacementSeries::Added DisplacementSeries::hold(std::int64_t time_ns, Vec2 at) {
  held_.push_back({time_ns, at, true});
  if (held_.size() < kHeld) return Added::nothing;
  std::vector<std::int64_t> differences;
  for (std::size_t i = 1; i < held_.size(); ++i) differences.push_back(held_[i].time_ns - held_[i - 1].time_ns);
  period_s_ = median_ns(std::move(differences)) * 1e-9;
  placed_ns_.reset();
  for (const Frame& frame : std::exchange(held_, {})) place(frame.time_ns, frame.at);
  appended_ = frames_.size();
  return Added::restarted;
}

DisplacementSeries::Added DisplacementSeries::place(std::int64_t time_ns, Vec2 at) {
  const double difference_s = placed_ns_ ? static_cast<double>(time_ns - *placed_ns_) * 1e-9 : 0;
  const bool restart = !placed_ns_ || difference_s > std::max(max_gap_s_, 3.5 * period_s_);
  if (restart) {
    frames_.clear();
    segment_frames_ = 0;
    late_steps_ = 0;
  } else {
    // Counted from a smoothed grid, because one late frame must not make the next one look early.
    const double steps = difference_s / period_s_ + late_steps_;
    if (steps < 0.5) return Added::nothing;  // doubled: the one that came first stands
    const auto whole = std::max<std::int64_t>(1, std::llround(steps));
    late_steps_ = (1 - kGridGain) * (steps - static_cast<double>(whole));
    for (std::int64_t i = 1; i < whole; ++i) {
      const std::int64_t missing_ns = *placed_ns_ + (time_ns - *placed_ns_) * i / whole;
      append(missing_ns, {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()}, false);
    }
  }
  placed_ns_ = time_ns;
  append(time_ns, at, true);
  // A median of few differences is rough where times jitter: better ones as they come.
  if (frames_.size() == 2 * kHeld || frames_.size() == 8 * kHeld) refine_period();
  return restart ? Added::restarted : Added::appended;
}

void DisplacementSeries::keep_newest(std::size_t count) {
  if (frames_.size() <= count) return;
  auto surplus = static_cast<std::ptrdiff_t>(frames_.size() - count);
  // The first frame kept is a measured one, so that every hole has two ends.
  while (surplus > 0 && !frames_[static_cast<std::size_t>(surplus)].measured) --surplus;
  frames_.erase(frames_.begin(), frames_.begin() + surplus);
}

void DisplacementSeries::refine_period() {
  if (frames_.size() < 2 * kHeld) return;
  const double span_s = static_cast<double>(frames_.back().time_ns - frames_.front().time_ns) * 1e-9;
  const double refined_s = span_s / static_cast<double>(frames_.size() - 1);
  if (std::abs(refined_s / period_s_ - 1) < kRefineTolerance) period_s_ = refined_s;
}

std::vector<double> DisplacementSeries::along(Vec2 axis, std::size_t count) const {
  count = std::min(count, frames_.size());
  std::vector<double> result(count);
  const std::size_t begin = frames_.size() - count;
  // A hole that begins before the part wanted is filled from its true end.
  const auto value = [&](std::size_t i) { return axis.x * frames_[i].at.x + axis.y * frames_[i].at.y; };
  std::size_t before = begin;
  while (before > 0 && !frames_[before].measured) --before;
  for (std::size_t i = before; i < frames_.size(); ++i) {
    if (frames_[i].measured) {
      for (std::size_t hole = before + 1; hole < i; ++hole) {
        const double share = static_cast<double>(hole - before) / static_cast<double>(i - before);
        if (hole >= begin) result[hole - begin] = std::lerp(value(before), value(i), share);
      }
      before = i;
      if (i >= begin) result[i - begin] = value(i);
    }
  }
  return result;
}

Vec2 main_axis(const DisplacementSeries& series, std::size_t count, const Vec2* previous) {
  const auto x = detrend(series.along({1, 0}, count));
  const auto y = detrend(series.along({0, 1}, count));
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += x[i] * x[i];
    xy += x[i] * y[i];
    yy += y[i] * y[i];
  }
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
  Vec2 axis{std::cos(angle), std::sin(angle)};
  const bool turn = previous != nullptr                ? axis.x * previous->x + axis.y * previous->y < 0
                    : std::abs(axis.x) < kVerticalSine ? axis.y < 0
                                                       : axis.x < 0;
  if (turn) axis = {-axis.x, -axis.y};
  return axis;
}

}  // namespace roseau::estimation
