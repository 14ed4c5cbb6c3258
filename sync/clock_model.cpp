#include "sync/clock_model.h"

#include <algorithm>
#include <cmath>

namespace roseau::sync {

namespace {
// Interval statistics forget over about this many arrivals.
constexpr double kIntervalMemory = 200;
// The hull is fitted once per this much device time: often enough to follow, seldom enough to cost nothing.
constexpr std::int64_t kFitInterval_ns = 1'000'000'000;
// Below this span a slope would be noise: until then the device is taken to run at the host's rate.
constexpr std::int64_t kMinSlopeSpan_ns = 5'000'000'000;
}  // namespace

void HostStampedClock::observe(std::optional<DeviceTime> /*device*/, HostTime arrival) {
  ++count_;
  if (count_ >= 2) {
    const double interval_s = to_seconds(arrival - last_arrival_);
    const double weight = 1.0 / std::min(static_cast<double>(count_ - 1), kIntervalMemory);
    const double deviation = interval_s - mean_interval_s_;
    mean_interval_s_ += weight * deviation;
    interval_variance_s2_ += weight * (deviation * (interval_s - mean_interval_s_) - interval_variance_s2_);
  }
  last_arrival_ = arrival;
}

HostTime HostStampedClock::to_host(DeviceTime device) const { return host_time_from_ns(to_ns(device)); }

ClockState HostStampedClock::state() const {
  ClockState state;
  state.jitter_s = std::sqrt(std::max(0.0, interval_variance_s2_) / 2);
  state.samples = count_;
  return state;
}

void LowerHullClock::restart() {
  points_.clear();
  fitted_ = false;
  outliers_in_a_row_ = 0;
}

double LowerHullClock::predicted_delay_ns(std::int64_t device_ns) const {
  return delay_at_anchor_ns_ + slope_ * static_cast<double>(device_ns - anchor_device_ns_);
}

bool LowerHullClock::is_step(const Point& point) const {
  if (!points_.empty() && point.device_ns <= points_.back().device_ns) return true;
  if (!fitted_) return false;
  const double residual_ns = static_cast<double>(point.delay_ns) - predicted_delay_ns(point.device_ns);
  return std::abs(residual_ns) > static_cast<double>(options_.step_threshold.count());
}

void LowerHullClock::observe(std::optional<DeviceTime> device, HostTime arrival) {
  if (!device) return;
  ++count_;
  const Point point{to_ns(*device), to_ns(arrival) - to_ns(*device)};
  if (is_step(point)) {
    if (++outliers_in_a_row_ < options_.outliers_for_reset) return;
    ++resets_;
    restart();
  }
  outliers_in_a_row_ = 0;
  points_.push_back(point);
  while (points_.front().device_ns < point.device_ns - options_.memory.count()) points_.pop_front();
  const bool young = points_.back().device_ns - points_.front().device_ns < kFitInterval_ns;
  if (!fitted_ || young || point.device_ns - last_fit_device_ns_ >= kFitInterval_ns) fit();
}

void LowerHullClock::fit() {
  // Andrew's monotone chain, lower side. Products of 60 s and 1e18 ns would overflow int64: differences go through long double.
  hull_.clear();
  for (const Point& point : points_) {
    while (hull_.size() >= 2) {
      const Point& before = hull_[hull_.size() - 2];
      const Point& last = hull_.back();
      const auto cross = static_cast<long double>(last.device_ns - before.device_ns) *
                             static_cast<long double>(point.delay_ns - before.delay_ns) -
                         static_cast<long double>(last.delay_ns - before.delay_ns) *
                             static_cast<long double>(point.device_ns - before.device_ns);
      if (cross > 0) break;
      hull_.pop_back();
    }
    hull_.push_back(point);
  }
  last_fit_device_ns_ = points_.back().device_ns;
  const std::int64_t span_ns = points_.back().device_ns - points_.front().device_ns;
  fitted_ = true;
  if (span_ns < kMinSlopeSpan_ns) {
    const auto lowest = std::ranges::min_element(points_, {}, &Point::delay_ns);
    anchor_device_ns_ = lowest->device_ns;
    delay_at_anchor_ns_ = static_cast<double>(lowest->delay_ns);
    slope_ = 0;
    return;
  }
  const std::int64_t middle_ns = points_.front().device_ns + span_ns / 2;
  const auto right = std::ranges::find_if(hull_, [middle_ns](const Point& point) { return point.device_ns >= middle_ns; });
  const Point& b = *right;
  const Point& a = right == hull_.begin() ? *right : *(right - 1);
  anchor_device_ns_ = b.device_ns;
  delay_at_anchor_ns_ = static_cast<double>(b.delay_ns);
  slope_ = a.device_ns == b.device_ns
               ? 0
               : static_cast<double>(b.delay_ns - a.delay_ns) / static_cast<double>(b.device_ns - a.device_ns);
}

HostTime LowerHullClock::to_host(DeviceTime device) const {
  const std::int64_t device_ns = to_ns(device);
  return host_time_from_ns(device_ns + std::llround(predicted_delay_ns(device_ns)));
}

ClockState LowerHullClock::state() const {
  ClockState state;
  state.samples = count_;
  state.resets = resets_;
  if (!fitted_) return state;
  state.offset_s = predicted_delay_ns(points_.back().device_ns) * 1e-9;
  state.frequency_offset_ppm = -slope_ * 1e6;
  // Arrivals lie above the hull by their latency's random part: its spread is the jitter, and the hull's own uncertainty is
  // of the order of the smallest excess, mean / n for an exponential tail.
  double sum_ns = 0;
  double sum_squares = 0;
  for (const Point& point : points_) {
    const double excess_ns = static_cast<double>(point.delay_ns) - predicted_delay_ns(point.device_ns);
    sum_ns += excess_ns;
    sum_squares += excess_ns * excess_ns;
  }
  const auto n = static_cast<double>(points_.size());
  const double mean_ns = sum_ns / n;
  state.jitter_s = std::sqrt(std::max(0.0, sum_squares / n - mean_ns * mean_ns)) * 1e-9;
  state.offset_sd_s = std::max(mean_ns, 0.0) / n * 2e-9;
  return state;
}

}  // namespace roseau::sync
