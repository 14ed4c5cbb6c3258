#include "core/wind_statistics.h"

#include <cmath>

namespace roseau {

void WindStatistics::add(const WindSample& sample) {
  if (!sample.valid || !std::isfinite(sample.u_mps) || !std::isfinite(sample.v_mps)) {
    ++left_out_;
    return;
  }
  ++count_;
  const double w_mps = std::isfinite(sample.w_mps) ? sample.w_mps : 0.0;
  const double horizontal_mps = std::hypot(sample.u_mps, sample.v_mps);
  sum_mps_ = {sum_mps_.x + sample.u_mps, sum_mps_.y + sample.v_mps, sum_mps_.z + w_mps};
  speed_horizontal_sum_mps_ += horizontal_mps;
  speed_3d_sum_mps_ += std::hypot(horizontal_mps, w_mps);
  if (horizontal_mps > 0) {
    unit_sum_ = {unit_sum_.x + sample.u_mps / horizontal_mps, unit_sum_.y + sample.v_mps / horizontal_mps};
  }
}

double WindStatistics::mean(double sum) const { return count_ == 0 ? kNotMeasured : sum / static_cast<double>(count_); }

Vec3 WindStatistics::mean_vector_mps() const { return {mean(sum_mps_.x), mean(sum_mps_.y), mean(sum_mps_.z)}; }

double WindStatistics::vector_mean_speed_mps() const {
  const Vec3 vector = mean_vector_mps();
  return std::hypot(vector.x, vector.y, vector.z);
}

double WindStatistics::scalar_mean_speed_3d_mps() const { return mean(speed_3d_sum_mps_); }

double WindStatistics::scalar_mean_speed_horizontal_mps() const { return mean(speed_horizontal_sum_mps_); }

double WindStatistics::unit_vector_mean_direction_deg(double north_offset_deg, WindAxes axes) const {
  if (unit_sum_.x == 0 && unit_sum_.y == 0) return kNotMeasured;
  return wind_direction_deg(unit_sum_.x, unit_sum_.y, north_offset_deg, axes);
}

}  // namespace roseau
