#include "recorder/control/trigger.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <utility>

namespace roseau::recorder {

namespace {

// Nothing usable for this long: the instrument is gone, and nobody knows whether the condition still holds.
constexpr Duration kSilence = std::chrono::seconds(5);

constexpr std::array<std::pair<std::string_view, TriggerQuantity>, 4> kQuantities = {{
    {"wind_speed_mps", TriggerQuantity::wind_speed_mps},
    {"gust_mps", TriggerQuantity::gust_mps},
    {"displacement_rms", TriggerQuantity::displacement_rms},
    {"displacement_amplitude", TriggerQuantity::displacement_amplitude},
}};

std::optional<double> wind_speed_mps(const Sample& sample) {
  double speed = kNotMeasured;
  if (const auto* wind = std::get_if<WindSample>(&sample.payload)) {
    if (wind->valid) speed = std::hypot(wind->u_mps, wind->v_mps);
  } else if (const auto* estimate = std::get_if<WindEstimate>(&sample.payload)) {
    if (estimate->accepted) speed = std::abs(estimate->wind_mps);
  }
  return std::isfinite(speed) ? std::optional(speed) : std::nullopt;
}

bool is_of_wind(TriggerQuantity quantity) {
  return quantity == TriggerQuantity::wind_speed_mps || quantity == TriggerQuantity::gust_mps;
}

}  // namespace

std::string_view to_string(TriggerQuantity quantity) { return kQuantities.at(static_cast<std::size_t>(quantity)).first; }

Result<TriggerQuantity> trigger_quantity_from_string(std::string_view name) {
  const auto* found = std::ranges::find(kQuantities, name, [](const auto& entry) { return entry.first; });
  if (found != kQuantities.end()) return found->second;
  return Error{ErrorCode::invalid_argument,
               "'" + std::string(name) + "' is not one of wind_speed_mps, gust_mps, displacement_rms, displacement_amplitude"};
}

void SlidingMoments::add(HostTime time, double value) {
  if (entries_.empty()) origin_ = value;
  if (entries_.empty() || time - entries_.back().time > window_) begin_ = time;
  entries_.push_back({time, value});
  sum_ += value - origin_;
  square_sum_ += (value - origin_) * (value - origin_);
  while (entries_.front().time < time - window_) {
    const double old = entries_.front().value - origin_;
    sum_ -= old;
    square_sum_ -= old * old;
    entries_.pop_front();
  }
  // Adding and taking away leaves rounding errors behind that would grow for as long as the program runs.
  if (--until_summed_anew_ == 0) sum_anew();
}

void SlidingMoments::sum_anew() {
  origin_ = mean();
  sum_ = 0;
  square_sum_ = 0;
  for (const Entry& entry : entries_) {
    sum_ += entry.value - origin_;
    square_sum_ += (entry.value - origin_) * (entry.value - origin_);
  }
  until_summed_anew_ = entries_.size();
}

bool SlidingMoments::is_settled() const { return !entries_.empty() && entries_.back().time - begin_ >= window_; }

double SlidingMoments::mean() const { return origin_ + sum_ / static_cast<double>(entries_.size()); }

double SlidingMoments::variance() const {
  const auto count = static_cast<double>(entries_.size());
  return std::max(0.0, square_sum_ / count - (sum_ / count) * (sum_ / count));
}

std::optional<double> Trigger::value_of(const Sample& sample) {
  constexpr std::uint16_t kUnusable = kStatusBadChecksum | kStatusMalformed | kStatusDeviceError | kStatusDuplicate;
  if ((sample.header.status & kUnusable) != 0) return std::nullopt;
  const HostTime time = sample.header.sample_time;
  if (is_of_wind(options_.quantity)) {
    const auto speed = wind_speed_mps(sample);
    if (!speed || options_.quantity == TriggerQuantity::wind_speed_mps) return speed;
    x_.add(time, *speed);
    return x_.is_settled() ? std::optional(*speed - x_.mean()) : std::nullopt;
  }
  const auto* moved = std::get_if<Displacement>(&sample.payload);
  if (moved == nullptr || !moved->valid || !std::isfinite(moved->x) || !std::isfinite(moved->y)) return std::nullopt;
  x_.add(time, moved->x);
  y_.add(time, moved->y);
  if (!x_.is_settled()) return std::nullopt;
  if (options_.quantity == TriggerQuantity::displacement_rms) return std::sqrt(x_.variance() + y_.variance());
  return std::hypot(moved->x - x_.mean(), moved->y - y_.mean());
}

std::optional<TriggerEvent> Trigger::see(const Sample& sample, HostTime log_time) {
  const auto value = value_of(sample);
  if (!value) return tick(log_time);
  last_seen_ = log_time;
  return judge(*value, sample.header.sample_time, log_time);
}

std::optional<TriggerEvent> Trigger::judge(double value, HostTime sample_time, HostTime log_time) {
  if (is_on_) {
    if (value >= options_.above - options_.hysteresis && value > 0) return std::nullopt;
    return end(log_time, "below the threshold");
  }
  if (!(value > options_.above)) {
    above_since_.reset();
    return std::nullopt;
  }
  if (!above_since_) above_since_ = sample_time;
  if (sample_time - *above_since_ < options_.for_at_least) return std::nullopt;
  if (last_fired_ && log_time - *last_fired_ < options_.rearm) return std::nullopt;
  is_on_ = true;
  last_fired_ = log_time;
  std::ostringstream reason;
  reason.precision(3);
  reason << to_string(options_.quantity) << ' ' << value << " on " << options_.topic << ", above " << options_.above;
  return TriggerEvent{true, log_time, options_.name, reason.str()};
}

std::optional<TriggerEvent> Trigger::tick(HostTime now) {
  if (!is_on_ || now - last_seen_ < kSilence) return std::nullopt;
  return end(now, "nothing usable came for 5 s");
}

TriggerEvent Trigger::end(HostTime at, const std::string& why) {
  is_on_ = false;
  above_since_.reset();
  return {false, at, options_.name, why};
}

TriggerWatch::TriggerWatch(const std::vector<TriggerOptions>& triggers, const StreamTable& streams) : streams_(streams) {
  for (const TriggerOptions& options : triggers) triggers_.emplace_back(options);
}

std::vector<TriggerEvent> TriggerWatch::see(const Sample& sample, HostTime log_time) {
  std::vector<TriggerEvent> events;
  if (triggers_.empty()) return events;
  const std::string& topic = streams_.info(sample.header.stream).topic;
  for (Trigger& trigger : triggers_) {
    auto event = trigger.options().topic == topic ? trigger.see(sample, log_time) : trigger.tick(log_time);
    if (event) events.push_back(std::move(*event));
  }
  return events;
}

}  // namespace roseau::recorder
