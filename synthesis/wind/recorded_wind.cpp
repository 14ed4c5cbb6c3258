#include "synthesis/wind/recorded_wind.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace roseau::synthesis {

namespace {
constexpr double kLongestHoleS = 2;
constexpr double kSeamS = 2;
constexpr double kLeastSpeedMps = 0.1;

bool is_number(const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

Vec3 between(const Vec3& a, const Vec3& b, double share) {
  return {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y), a.z + share * (b.z - a.z)};
}

Error wrong(std::string what) { return {ErrorCode::invalid_argument, "wind.recording: " + std::move(what)}; }

Result<std::vector<Vec3>> bridge_holes(std::vector<Vec3> samples, double rate_hz) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (is_number(samples[i])) continue;
    std::size_t end = i;
    while (end < samples.size() && !is_number(samples[end])) ++end;
    const double hole_s = static_cast<double>(end - i) / rate_hz;
    if (hole_s > kLongestHoleS || (i == 0 && end == samples.size())) {
      return wrong(fmt::format("no wind for {:.1f} s from {:.1f} s on (at most {} s can be bridged): cut the recording", hole_s,
                               static_cast<double>(i) / rate_hz, kLongestHoleS));
    }
    const Vec3 before = i > 0 ? samples[i - 1] : samples[end];
    const Vec3 after = end < samples.size() ? samples[end] : before;
    const auto steps = static_cast<double>(end - i + 1);
    for (std::size_t k = i; k < end; ++k) samples[k] = between(before, after, static_cast<double>(k - i + 1) / steps);
    i = end;
  }
  return samples;
}

// The last samples fade into the first; the loop is shorter by them.
std::vector<Vec3> close_loop(std::vector<Vec3> samples, double rate_hz) {
  const std::size_t seam = std::min(static_cast<std::size_t>(kSeamS * rate_hz), samples.size() / 10);
  const std::size_t loop = samples.size() - seam;
  for (std::size_t i = 0; i < seam; ++i) {
    samples[i] = between(samples[loop + i], samples[i], static_cast<double>(i) / static_cast<double>(seam));
  }
  samples.resize(loop);
  return samples;
}

// How far along the wind the region reaches, both ways from a place.
std::pair<double, double> reach_m(const WindRegion& region, const Vec3& place, const Vec3& along) {
  std::vector<Vec3> points = region.instruments_in_world_m;
  if (region.crown) {
    const Vec3& low = region.crown->low_in_world_m;
    const Vec3& high = region.crown->high_in_world_m;
    points.insert(points.end(), {low, {low.x, high.y, low.z}, {high.x, low.y, low.z}, high});
  }
  double upwind_m = 0;
  double downwind_m = 0;
  for (const Vec3& point : points) {
    const double ahead_m = (point.x - place.x) * along.x + (point.y - place.y) * along.y;
    upwind_m = std::max(upwind_m, -ahead_m);
    downwind_m = std::max(downwind_m, ahead_m);
  }
  return {upwind_m, downwind_m};
}
}  // namespace

Vec3 velocity_in_world_mps(const WindSample& sample, double north_offset_deg, WindAxes axes) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  if (!sample.valid) return {kNan, kNan, kNan};
  const double from_rad = wind_direction_deg(sample.u_mps, sample.v_mps, north_offset_deg, axes) * std::numbers::pi / 180;
  const double speed_mps = std::hypot(sample.u_mps, sample.v_mps);
  return {-speed_mps * std::sin(from_rad), -speed_mps * std::cos(from_rad), sample.w_mps};
}

Vec3 mean_mps(const std::vector<Vec3>& samples_mps) {
  Vec3 sum;
  double count = 0;
  for (const Vec3& sample : samples_mps) {
    if (!is_number(sample)) continue;
    sum = {sum.x + sample.x, sum.y + sample.y, sum.z + sample.z};
    ++count;
  }
  return count > 0 ? Vec3{sum.x / count, sum.y / count, sum.z / count} : Vec3{};
}

Result<std::shared_ptr<const RecordedWind>> RecordedWind::make(const RecordedWindOptions& options, const WindRegion& region) {
  if (options.samples_mps.size() < 4)
    return wrong(fmt::format("has {} samples, at least 4 are needed", options.samples_mps.size()));
  const Vec3 mean = synthesis::mean_mps(options.samples_mps);
  if (const double speed_mps = std::hypot(mean.x, mean.y); speed_mps < kLeastSpeedMps) {
    return wrong(
        fmt::format("its mean wind of {:.3f} m/s is too slow to carry it (at least {} m/s)", speed_mps, kLeastSpeedMps));
  }
  auto samples = bridge_holes(options.samples_mps, options.rate_hz);
  if (!samples) return samples.error();
  std::shared_ptr<const RecordedWind> wind(new RecordedWind(options, std::move(*samples)));
  if (auto checked = wind->check_length(region); !checked) return checked.error();
  return wind;
}

RecordedWind::RecordedWind(const RecordedWindOptions& options, std::vector<Vec3> samples)
    : samples_(std::move(samples)),
      rate_hz_(options.rate_hz),
      place_(options.place_in_world_m),
      start_s_(options.start_s),
      loops_(options.at_end == RecordingEnd::loop),
      mean_mps_(synthesis::mean_mps(samples_)),
      speed_mps_(std::hypot(mean_mps_.x, mean_mps_.y)),
      profile_({.shape = options.profile,
                .reference_height_m = options.place_in_world_m.z,
                .exponent = options.profile_exponent,
                .roughness_length_m = options.roughness_length_m,
                .displacement_height_m = options.displacement_height_m}) {
  along_ = {mean_mps_.x / speed_mps_, mean_mps_.y / speed_mps_, 0};
  if (loops_) samples_ = close_loop(std::move(samples_), rate_hz_);
}

Result<void> RecordedWind::check_length(const WindRegion& region) const {
  if (loops_) return {};
  const auto [upwind_m, downwind_m] = reach_m(region, place_, along_);
  const double first_s = start_s_ - downwind_m / speed_mps_;
  const double last_s = start_s_ + region.duration_s + upwind_m / speed_mps_;
  const double length_s = static_cast<double>(samples_.size() - 1) / rate_hz_;
  if (first_s >= 0 && last_s <= length_s) return {};
  const double earliest_s = start_s_ - first_s;
  const double latest_s = start_s_ + length_s - last_s;
  const std::string remedy = earliest_s <= latest_s
                                 ? fmt::format("a start_s from {:.2f} to {:.2f} would do", earliest_s, latest_s)
                                 : "choose at_end = \"loop\" or a shorter session";
  return wrong(fmt::format("lasts {:.2f} s, but {:.2f} to {:.2f} s of it are needed to blow over the whole region: {}",
                           length_s, first_s, last_s, remedy));
}

double RecordedWind::recording_time_s(const Vec3& point, double time_s) const {
  const double ahead_m = (point.x - place_.x) * along_.x + (point.y - place_.y) * along_.y;
  return start_s_ + time_s - ahead_m / speed_mps_;
}

Vec3 RecordedWind::sample(std::int64_t index) const {
  const auto size = static_cast<std::int64_t>(samples_.size());
  if (loops_) index = ((index % size) + size) % size;
  return samples_[static_cast<std::size_t>(std::clamp<std::int64_t>(index, 0, size - 1))];
}

Vec3 RecordedWind::velocity_mps(const Vec3& point_in_world, double time_s) const {
  const auto size = static_cast<double>(samples_.size());
  double position = recording_time_s(point_in_world, time_s) * rate_hz_;
  position = loops_ ? position - size * std::floor(position / size) : std::clamp(position, 0.0, size - 1);
  const double not_a_number = position + point_in_world.z;
  if (!std::isfinite(not_a_number)) return {not_a_number, not_a_number, not_a_number};
  const double whole = std::floor(position);
  const double s = position - whole;
  const auto first = static_cast<std::int64_t>(whole) - 1;
  const double weights[4] = {s * (-0.5 + s * (1 - 0.5 * s)), 1 + s * s * (-2.5 + 1.5 * s), s * (0.5 + s * (2 - 1.5 * s)),
                             s * s * (-0.5 + 0.5 * s)};
  const double above = profile_.ratio(point_in_world.z) - 1;
  Vec3 sum{mean_mps_.x * above, mean_mps_.y * above, 0};
  for (int i = 0; i < 4; ++i) {
    const Vec3 its = sample(first + i);
    sum = {sum.x + weights[i] * its.x, sum.y + weights[i] * its.y, sum.z + weights[i] * its.z};
  }
  return sum;
}

}  // namespace roseau::synthesis
