// From force to metres per second, against a reference anemometer: V |V|^(n-1) = a u + b.
//
// u is the static displacement (force per mass / w0^2: latent_force_kalman.h), V the reference wind's component along one
// horizontal direction, n = 2 for rigid drag and less where the plant streamlines (2 + Vogel exponent). Which component: the
// stated direction, else that of best correlation. Both are low-passed before fitting, because above about 0.1 Hz a reference a
// few metres away no longer feels the same gusts. docs/estimation.md says what limits it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry.h"
#include "core/result.h"
#include "core/time.h"

namespace roseau::estimation {

struct CalibrationOptions {
  double low_pass_hz = 0.1;  // half amplitude of a raised-cosine window of 1 / low_pass_hz
  double max_delay_s = 3;    // reference later or earlier than the target: travel of the gusts plus clocks
  double min_exponent = 1;
  double max_exponent = 2.2;
  double exponent_step = 0.05;
  double expected_exponent = 1.8;  // weak normal prior on n: decides only while the wind has hardly varied
  double expected_exponent_sd = 0.4;
  /// The wind that pushes the target along +axis comes from here, degrees clockwise from north. Unset: best correlation.
  std::optional<double> direction_deg;
  /// Static displacement in still air, if known: holds the curve's foot.
  std::optional<double> rest_displacement;
  double min_duration_s = 20;
  double max_duration_s = 3600;   // older data are forgotten
  double held_out_after_s = 180;  // from this much data on, the last third is held out to judge
  double integral_time_s = 15;    // one independent gust per this long: degrees of freedom
  int bootstrap_replicates = 0;   // moving blocks of 20 s; 0 = no confidence intervals
};

/// 95 % confidence interval.
struct Interval {
  double low = 0;
  double high = 0;

  template <class Archive>
  void archive(Archive& a) {
    a(low), a(high);
  }
};

struct CalibrationFit {
  double gain = 0;      // a: (m/s)^n per unit of static displacement
  double offset = 0;    // b: (m/s)^n
  double exponent = 2;  // n
  double delay_s = 0;   // reference later than the target: positive
  double direction_deg = 0;
  std::optional<double> explained;  // on the held-out third: 1 - MSE / Var
  double correlation = 0;           // on the held-out third, or where there is none yet on what it was fitted to;
  double rms_mps = 0;               // both in the low-passed band
  double seconds_used = 0;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of (gain, offset), for independent gusts only
  std::optional<Interval> gain_interval;
  std::optional<Interval> offset_interval;
  std::optional<Interval> exponent_interval;

  double wind_mps(double static_displacement) const;
  /// From the static displacement's own spread and the calibration's.
  double wind_sd_mps(double static_displacement, double static_displacement_sd) const;

  template <class Archive>
  void archive(Archive& a) {
    a(gain), a(offset), a(exponent), a(delay_s), a(direction_deg), a(explained), a(correlation), a(rms_mps), a(seconds_used);
    a(covariance(0, 0)), a(covariance(0, 1)), a(covariance(1, 0)), a(covariance(1, 1));
    a(gain_interval), a(offset_interval), a(exponent_interval);
  }
};

/// sign(x) |x|^power
double signed_power(double x, double power);

/// Means over steps of host time of irregular samples: what calibration works on. Bins without a sample are NaN.
class GridSeries {
 public:
  static constexpr std::int64_t kStep_ns = 500'000'000;
  static constexpr double kStep_s = 0.5;

  explicit GridSeries(double max_duration_s) : capacity_(static_cast<std::size_t>(max_duration_s / kStep_s)) {}

  /// Times must not go back by more than a bin; older samples are ignored.
  void add(HostTime time, Vec2 value);
  void clear();

  /// Step number (host time / kStep_ns) of values().front().
  std::int64_t first() const { return first_; }
  std::int64_t end() const { return first_ + static_cast<std::int64_t>(bins_.size()); }
  /// NaN outside.
  Vec2 at(std::int64_t step) const;

  template <class Archive>
  void archive(Archive& a) {
    a(first_), a(bins_);
  }

 private:
  struct Bin {
    Vec2 sum;
    std::uint32_t count = 0;

    template <class Archive>
    void archive(Archive& a) {
      a(sum.x), a(sum.y), a(count);
    }
  };

  std::size_t capacity_;
  std::int64_t first_ = 0;
  std::vector<Bin> bins_;
};

/// Horizontal wind as (speed sin from, speed cos from): how much of it comes from the east and from the north.
Vec2 wind_from_components(double speed_mps, double from_deg);

/// Fits on the steps the two series share. `target`: x = static displacement. `reference`: wind_from_components. Error
/// (invalid_argument) when they share too little, or when one of them does not vary.
Result<CalibrationFit> calibrate_wind(const GridSeries& target, const GridSeries& reference,
                                      const CalibrationOptions& options = {});

}  // namespace roseau::estimation
