// Mean wind of a record, in the ways people mean by "mean": they differ, so each has its own name.
//
//   unit-vector mean direction   direction of the mean of (u, v) / hypot(u, v): every sample counts alike (EddyPro's wind_dir)
//   vector mean speed            length of the mean of (u, v, w) (EddyPro's wind_speed)
//   scalar mean speed            mean of each sample's own speed: in 3-D, or of its horizontal part
//
// On a gusty or turning wind the scalar means exceed the vector mean.
#pragma once

#include <cstdint>

#include "core/geometry.h"
#include "core/sample.h"
#include "core/wind_geometry.h"

namespace roseau {

/// Accumulates samples in any order. Those without a valid horizontal wind are counted and left out; of a 2-D instrument
/// (w not measured) the 3-D figures are the horizontal ones.
class WindStatistics {
 public:
  void add(const WindSample& sample);

  std::uint64_t samples() const { return count_; }
  std::uint64_t left_out() const { return left_out_; }

  /// The figures below are NaN without a sample.
  Vec3 mean_vector_mps() const;
  double vector_mean_speed_mps() const;
  double scalar_mean_speed_3d_mps() const;
  double scalar_mean_speed_horizontal_mps() const;
  /// NaN when there was no wind at all, or from all sides alike.
  double unit_vector_mean_direction_deg(double north_offset_deg, WindAxes axes = WindAxes::gill_spar) const;

 private:
  double mean(double sum) const;

  std::uint64_t count_ = 0;
  std::uint64_t left_out_ = 0;
  Vec3 sum_mps_;
  Vec2 unit_sum_;  // calm samples have no direction and add nothing
  double speed_3d_sum_mps_ = 0;
  double speed_horizontal_sum_mps_ = 0;
};

}  // namespace roseau
