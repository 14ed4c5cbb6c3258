#include "estimation/wind_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace roseau::estimation {

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kBlock_s = 20;
constexpr std::size_t kRestPoints = 20;  // a known rest position weighs as much as this many seconds of still air
constexpr double kDirectionPreference = 0.02;
constexpr double kFewestCorrelation = 0.3;  // below it a delay found is chance
constexpr std::size_t kPointSteps = 2;      // fitted points are a second apart: the band ends at 0.1 Hz

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

double component(Vec2 from, double direction_deg) {
  return from.x * std::sin(radians(direction_deg)) + from.y * std::cos(radians(direction_deg));
}

// Both series on the steps they share.
struct Aligned {
  std::vector<double> target;
  std::vector<Vec2> reference;
  double duration_s() const { return static_cast<double>(target.size()) * GridSeries::kStep_s; }
  Aligned part(std::size_t begin, std::size_t end) const {
    const auto from = static_cast<std::ptrdiff_t>(begin);
    const auto to = static_cast<std::ptrdiff_t>(end);
    return {{target.begin() + from, target.begin() + to}, {reference.begin() + from, reference.begin() + to}};
  }
};

Aligned align(const GridSeries& target, const GridSeries& reference, double max_duration_s) {
  const std::int64_t end = std::min(target.end(), reference.end());
  const auto longest = static_cast<std::int64_t>(max_duration_s / GridSeries::kStep_s);
  const std::int64_t begin = std::max({target.first(), reference.first(), end - longest});
  Aligned aligned;
  for (std::int64_t step = begin; step < end; ++step) {
    aligned.target.push_back(target.at(step).x);
    aligned.reference.push_back(reference.at(step));
  }
  return aligned;
}

// Raised cosine over 1 / cut: half amplitude at the cut. Its weights are positive, so that it may be renormalised over gaps and
// at the ends; fewer than half of the weights present give NaN.
template <class Get>
std::vector<double> low_pass(std::size_t count, double cut_hz, const Get& get) {
  const auto half = static_cast<std::ptrdiff_t>(std::ceil(0.5 / (cut_hz * GridSeries::kStep_s)));
  std::vector<double> weights;
  for (std::ptrdiff_t i = -half; i <= half; ++i) {
    weights.push_back(1 + std::cos(2 * std::numbers::pi * static_cast<double>(i) * GridSeries::kStep_s * cut_hz));
  }
  double full = 0;
  for (const double weight : weights) full += weight;
  std::vector<double> result(count, kNan);
  for (std::size_t at = 0; at < count; ++at) {
    double sum = 0;
    double weight_sum = 0;
    for (std::ptrdiff_t i = -half; i <= half; ++i) {
      const std::ptrdiff_t index = static_cast<std::ptrdiff_t>(at) + i;
      if (index < 0 || index >= static_cast<std::ptrdiff_t>(count)) continue;
      const double value = get(static_cast<std::size_t>(index));
      if (std::isnan(value)) continue;
      const double weight = weights[static_cast<std::size_t>(i + half)];
      sum += weight * value;
      weight_sum += weight;
    }
    if (weight_sum >= 0.5 * full) result[at] = sum / weight_sum;
  }
  return result;
}

Aligned low_pass(const Aligned& raw, double cut_hz) {
  Aligned slow;
  const std::size_t count = raw.target.size();
  slow.target = low_pass(count, cut_hz, [&](std::size_t i) { return raw.target[i]; });
  const auto x = low_pass(count, cut_hz, [&](std::size_t i) { return raw.reference[i].x; });
  const auto y = low_pass(count, cut_hz, [&](std::size_t i) { return raw.reference[i].y; });
  for (std::size_t i = 0; i < count; ++i) slow.reference.push_back({x[i], y[i]});
  return slow;
}

class Correlation {
 public:
  void add(double x, double y) {
    if (std::isnan(x) || std::isnan(y)) return;
    ++count_;
    const double dx = x - mean_x_;
    const double dy = y - mean_y_;
    mean_x_ += dx / count_;
    mean_y_ += dy / count_;
    xx_ += dx * (x - mean_x_);
    yy_ += dy * (y - mean_y_);
    xy_ += dx * (y - mean_y_);
  }
  double value() const { return count_ > 2 && xx_ > 0 && yy_ > 0 ? xy_ / std::sqrt(xx_ * yy_) : 0; }

 private:
  double count_ = 0;
  double mean_x_ = 0;
  double mean_y_ = 0;
  double xx_ = 0;
  double yy_ = 0;
  double xy_ = 0;
};

// Of the target with the drag V|V| of the reference's component, the reference taken `steps` later.
double drag_correlation(const Aligned& series, double direction_deg, std::ptrdiff_t steps) {
  Correlation correlation;
  const auto count = static_cast<std::ptrdiff_t>(series.target.size());
  for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(0, -steps); i < std::min(count, count - steps); ++i) {
    const double wind = component(series.reference[static_cast<std::size_t>(i + steps)], direction_deg);
    correlation.add(series.target[static_cast<std::size_t>(i)], wind * std::abs(wind));
  }
  return correlation.value();
}

// While the wind hardly turns every component correlates alike, the smallest one too: a little weight on how much of the wind
// a component holds then decides for the direction it blows along.
double best_direction(const Aligned& slow, std::ptrdiff_t steps) {
  double total = 0;
  for (const Vec2& wind : slow.reference) total += std::isnan(wind.x) ? 0 : wind.x * wind.x + wind.y * wind.y;
  double best = -1;
  double best_deg = 0;
  bool against = false;
  const auto consider = [&](double direction_deg) {
    double held = 0;
    for (const Vec2& wind : slow.reference) held += std::isnan(wind.x) ? 0 : std::pow(component(wind, direction_deg), 2);
    const double correlation = drag_correlation(slow, direction_deg, steps);
    const double score = std::abs(correlation) + kDirectionPreference * (total > 0 ? held / total : 0);
    if (score <= best) return;
    best = score;
    best_deg = direction_deg;
    against = correlation < 0;
  };
  for (int deg = 0; deg < 180; deg += 5) consider(deg);
  const double coarse_deg = best_deg;
  for (int deg = -4; deg <= 4; ++deg) consider(coarse_deg + deg);
  // Positive: wind from there pushes the target along its axis.
  return std::fmod(best_deg + (against ? 180 : 0) + 360, 360);
}

// Peak of the cross-correlation over +-max_delay, by a parabola through its top.
double best_delay_s(const Aligned& raw, double direction_deg, double max_delay_s) {
  const auto reach = static_cast<std::ptrdiff_t>(max_delay_s / GridSeries::kStep_s);
  std::vector<double> correlation;
  for (std::ptrdiff_t steps = -reach; steps <= reach; ++steps) {
    correlation.push_back(std::abs(drag_correlation(raw, direction_deg, steps)));
  }
  const auto top = std::ranges::max_element(correlation);
  if (*top < kFewestCorrelation) return 0;
  const auto index = top - correlation.begin();
  double fraction = 0;
  if (index > 0 && index + 1 < std::ssize(correlation)) {
    const double curvature = top[-1] - 2 * top[0] + top[1];
    if (curvature < 0) fraction = 0.5 * (top[-1] - top[1]) / curvature;
  }
  return (static_cast<double>(index - reach) + fraction) * GridSeries::kStep_s;
}

struct Point {
  double target = 0;
  double wind_mps = 0;
};

// Where the reference is `delay` later, between its steps.
std::vector<Point> points(const Aligned& slow, double direction_deg, double delay_s) {
  std::vector<Point> result;
  const double steps = delay_s / GridSeries::kStep_s;
  const auto whole = static_cast<std::ptrdiff_t>(std::floor(steps));
  const double share = steps - std::floor(steps);
  for (std::size_t i = 0; i < slow.target.size(); i += kPointSteps) {
    const std::ptrdiff_t before = static_cast<std::ptrdiff_t>(i) + whole;
    if (before < 0 || before + 1 >= std::ssize(slow.reference)) continue;
    const Vec2 a = slow.reference[static_cast<std::size_t>(before)];
    const Vec2 b = slow.reference[static_cast<std::size_t>(before + 1)];
    const Vec2 between{std::lerp(a.x, b.x, share), std::lerp(a.y, b.y, share)};
    const Point point{slow.target[i], component(between, direction_deg)};
    if (!std::isnan(point.target) && !std::isnan(point.wind_mps)) result.push_back(point);
  }
  return result;
}

struct Line {
  double gain = 0;
  double offset = 0;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // as if every point were independent
};

// Least squares of V|V|^(n-1) on the static displacement; a known rest position enters as still air.
Line fit_line(std::span<const Point> data, double exponent, const CalibrationOptions& options) {
  std::vector<Point> rows;  // wind_mps holds the drag here
  for (const Point& point : data) rows.push_back({point.target, signed_power(point.wind_mps, exponent)});
  if (options.rest_displacement) rows.insert(rows.end(), kRestPoints, Point{*options.rest_displacement, 0});
  const auto count = static_cast<double>(rows.size());
  Point mean;
  for (const Point& row : rows) mean = {mean.target + row.target / count, mean.wind_mps + row.wind_mps / count};
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (const Point& row : rows) {
    xx += (row.target - mean.target) * (row.target - mean.target);
    xy += (row.target - mean.target) * (row.wind_mps - mean.wind_mps);
    yy += (row.wind_mps - mean.wind_mps) * (row.wind_mps - mean.wind_mps);
  }
  Line line;
  line.gain = xx > 0 ? xy / xx : 0;
  line.offset = mean.wind_mps - line.gain * mean.target;
  if (!(xx > 0)) return line;
  const double variance = std::max(0.0, yy - line.gain * xy) / std::max(1.0, count - 2);
  line.covariance << 1, -mean.target, -mean.target, xx / count + mean.target * mean.target;
  line.covariance *= variance / xx;
  return line;
}

double mean_square_error(std::span<const Point> data, const Line& line, double exponent) {
  double sum = 0;
  for (const Point& point : data) {
    const double error = signed_power(line.gain * point.target + line.offset, 1 / exponent) - point.wind_mps;
    sum += error * error;
  }
  return sum / static_cast<double>(data.size());
}

struct Curve {
  Line line;
  double exponent = 2;
};

// n by its error in metres per second, with a prior that matters only while the wind has hardly varied.
Curve fit_curve(std::span<const Point> data, const CalibrationOptions& options) {
  const double seconds = static_cast<double>(data.size() * kPointSteps) * GridSeries::kStep_s;
  const double gusts = std::max(1.0, seconds / options.integral_time_s);
  Curve best;
  double lowest = std::numeric_limits<double>::infinity();
  for (int step = 0;; ++step) {
    const double exponent = options.min_exponent + step * options.exponent_step;
    if (exponent > options.max_exponent + 1e-9) break;
    const Line line = fit_line(data, exponent, options);
    const double surprise = (exponent - options.expected_exponent) / options.expected_exponent_sd;
    const double cost = 0.5 * gusts * std::log(mean_square_error(data, line, exponent) + 1e-12) + 0.5 * surprise * surprise;
    if (cost >= lowest) continue;
    lowest = cost;
    best = {line, exponent};
  }
  return best;
}

struct Fit {
  Curve curve;
  double direction_deg = 0;
  double delay_s = 0;
  std::vector<Point> data;
};

Fit fit(const Aligned& raw, const Aligned& slow, const CalibrationOptions& options) {
  Fit result;
  // Direction and delay depend on each other: twice round is enough.
  for (int round = 0; round < 2; ++round) {
    const auto steps = static_cast<std::ptrdiff_t>(std::lround(result.delay_s / GridSeries::kStep_s));
    result.direction_deg = options.direction_deg ? *options.direction_deg : best_direction(slow, steps);
    result.delay_s = best_delay_s(raw, result.direction_deg, options.max_delay_s);
  }
  result.data = points(slow, result.direction_deg, result.delay_s);
  if (!result.data.empty()) result.curve = fit_curve(result.data, options);
  return result;
}

struct Judgement {
  double correlation = 0;
  double rms_mps = 0;
  double explained = 0;
};

Judgement judge(const Curve& curve, std::span<const Point> data) {
  Correlation correlation;
  double mean = 0;
  for (const Point& point : data) {
    correlation.add(signed_power(curve.line.gain * point.target + curve.line.offset, 1 / curve.exponent), point.wind_mps);
    mean += point.wind_mps / static_cast<double>(data.size());
  }
  double variance = 0;
  for (const Point& point : data)
    variance += (point.wind_mps - mean) * (point.wind_mps - mean) / static_cast<double>(data.size());
  const double error = mean_square_error(data, curve.line, curve.exponent);
  return {correlation.value(), std::sqrt(error), variance > 0 ? 1 - error / variance : 0};
}

Interval percentiles(std::vector<double> values) {
  std::ranges::sort(values);
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(std::llround(share * static_cast<double>(values.size() - 1)))];
  };
  return {at(0.025), at(0.975)};
}

// Moving blocks: neighbours stay neighbours, so that the gusts' own correlation widens the intervals as it should.
void add_intervals(CalibrationFit& result, std::span<const Point> data, const CalibrationOptions& options) {
  const auto block = static_cast<std::size_t>(kBlock_s / (GridSeries::kStep_s * kPointSteps));
  if (data.size() < 2 * block) return;
  std::mt19937_64 random(1);  // always the same blocks: the same data give the same intervals
  std::vector<double> gains;
  std::vector<double> offsets;
  std::vector<double> exponents;
  std::vector<Point> resampled(data.size());
  for (int replicate = 0; replicate < options.bootstrap_replicates; ++replicate) {
    for (std::size_t filled = 0; filled < data.size();) {
      const std::size_t start = random() % (data.size() - block + 1);
      for (std::size_t i = 0; i < block && filled < data.size(); ++i) resampled[filled++] = data[start + i];
    }
    const Curve curve = fit_curve(resampled, options);
    gains.push_back(curve.line.gain);
    offsets.push_back(curve.line.offset);
    exponents.push_back(curve.exponent);
  }
  result.gain_interval = percentiles(gains);
  result.offset_interval = percentiles(offsets);
  result.exponent_interval = percentiles(exponents);
}

bool varies(std::span<const Point> data) {
  return std::ranges::any_of(data, [&](const Point& point) { return point.target != data[0].target; }) &&
         std::ranges::any_of(data, [&](const Point& point) { return point.wind_mps != data[0].wind_mps; });
}

}  // namespace

double signed_power(double x, double power) { return std::copysign(std::pow(std::abs(x), power), x); }

Vec2 wind_from_components(double speed_mps, double from_deg) {
  return {speed_mps * std::sin(radians(from_deg)), speed_mps * std::cos(radians(from_deg))};
}

double CalibrationFit::wind_mps(double static_displacement) const {
  return signed_power(gain * static_displacement + offset, 1 / exponent);
}

double CalibrationFit::wind_sd_mps(double static_displacement, double static_displacement_sd) const {
  const Eigen::Vector2d row(static_displacement, 1);
  const double drag = gain * static_displacement + offset;
  const double drag_sd = std::sqrt(row.dot(covariance * row) + std::pow(gain * static_displacement_sd, 2));
  // Half the distance between both ends instead of a slope, which would be infinite in still air.
  return (signed_power(drag + drag_sd, 1 / exponent) - signed_power(drag - drag_sd, 1 / exponent)) / 2;
}

void GridSeries::add(HostTime time, Vec2 value) {
  if (!std::isfinite(value.x) || !std::isfinite(value.y)) return;
  const std::int64_t time_ns = to_ns(time);
  const std::int64_t step = time_ns / kStep_ns - (time_ns % kStep_ns < 0 ? 1 : 0);
  if (!bins_.empty() && step >= end() + static_cast<std::int64_t>(capacity_)) clear();  // nothing old is left to keep
  if (bins_.empty()) first_ = step;
  if (step < first_) return;
  while (end() <= step) bins_.emplace_back();
  Bin& bin = bins_[static_cast<std::size_t>(step - first_)];
  bin.sum = {bin.sum.x + value.x, bin.sum.y + value.y};
  ++bin.count;
  // In chunks, so that forgetting costs nothing per sample.
  if (bins_.size() > capacity_ + 600) {
    const std::size_t surplus = bins_.size() - capacity_;
    bins_.erase(bins_.begin(), bins_.begin() + static_cast<std::ptrdiff_t>(surplus));
    first_ += static_cast<std::int64_t>(surplus);
  }
}

void GridSeries::clear() { bins_.clear(); }

Vec2 GridSeries::at(std::int64_t step) const {
  if (step < first_ || step >= end()) return {kNan, kNan};
  const Bin& bin = bins_[static_cast<std::size_t>(step - first_)];
  if (bin.count == 0) return {kNan, kNan};
  return {bin.sum.x / bin.count, bin.sum.y / bin.count};
}

Result<CalibrationFit> calibrate_wind(const GridSeries& target, const GridSeries& reference,
                                      const CalibrationOptions& options) {
  const Aligned raw = align(target, reference, options.max_duration_s);
  const Aligned slow = low_pass(raw, options.low_pass_hz);
  const Fit whole = fit(raw, slow, options);
  const double seconds = static_cast<double>(whole.data.size() * kPointSteps) * GridSeries::kStep_s;
  if (seconds < options.min_duration_s || whole.data.size() < 8) {
    return Error{ErrorCode::invalid_argument, fmt::format("target and reference share {:.0f} s; a calibration needs {:.0f} s",
                                                          seconds, options.min_duration_s)};
  }
  if (!varies(whole.data))
    return Error{ErrorCode::invalid_argument, "target or reference wind does not vary: nothing to calibrate on"};

  CalibrationFit result;
  result.gain = whole.curve.line.gain;
  result.offset = whole.curve.line.offset;
  result.exponent = whole.curve.exponent;
  result.delay_s = whole.delay_s;
  result.direction_deg = whole.direction_deg;
  result.seconds_used = seconds;
  const double gusts = std::max(1.0, seconds / options.integral_time_s);
  result.covariance = whole.curve.line.covariance * (static_cast<double>(whole.data.size()) / gusts);

  Judgement judgement = judge(whole.curve, whole.data);
  if (raw.duration_s() >= options.held_out_after_s) {
    // Everything, direction and delay included, is fitted anew on the first two thirds; the filter's reach is left between.
    const std::size_t split = raw.target.size() * 2 / 3;
    const auto guard = static_cast<std::size_t>(0.5 / (options.low_pass_hz * GridSeries::kStep_s));
    const Fit early = fit(raw.part(0, split), slow.part(0, split - guard), options);
    const auto late = points(slow.part(split, slow.target.size()), early.direction_deg, early.delay_s);
    if (early.data.size() >= 8 && varies(early.data) && late.size() >= 8) {
      judgement = judge(early.curve, late);
      result.explained = judgement.explained;
    }
  }
  result.correlation = judgement.correlation;
  result.rms_mps = judgement.rms_mps;
  if (options.bootstrap_replicates > 0) add_intervals(result, whole.data, options);
  return result;
}

}  // namespace roseau::estimation
