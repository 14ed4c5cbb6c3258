// Motion of a region from the motions of its points: the displacement of its centre and how displacement changes across it
// (turning, stretching), robust against points that move otherwise.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "tracking/mean_shift.h"
#include "tracking/placement.h"

namespace roseau::tracking {

struct RegionPoint {
  Eigen::Vector2d offset;        // from the centre, px
  Eigen::Vector2d displacement;  // px
};

struct RegionFit {
  RegionMotion motion;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of motion.displacement: standard error squared, px^2
  double variance = 0;                                   // of one coordinate of one agreeing point, px^2
  std::vector<char> agrees;                              // per point, in the order given
  int agreeing = 0;
  bool found = false;

  /// Would this point have counted as agreeing?
  bool holds_for(const RegionPoint& point) const {
    return (point.displacement - motion.at(point.offset)).squaredNorm() <= kAgreeDistance2 * variance;
  }
};

/// Working memory is kept from call to call. One user at a time.
class RegionFitter {
 public:
  /// `expected` is a guess of the gradient (the frame before's): it makes the points' motions comparable while the mode is
  /// looked for, and stands in where the points do not tell. `noise_px` is the least scatter of one point. Fewer than three
  /// agreeing points: not found.
  const RegionFit& fit(std::span<const RegionPoint> points, const Eigen::Matrix2d& expected, double noise_px);

 private:
  void least_squares(std::span<const RegionPoint> points, const Eigen::Matrix2d& expected);
  void agree_within(std::span<const RegionPoint> points, double noise_px);

  RegionFit fit_;
  RobustMean mode_;
  std::vector<Eigen::Vector2d> draws_;
  std::vector<double> distances2_;
  Eigen::Matrix3d inverse_normal_ = Eigen::Matrix3d::Zero();
};

}  // namespace roseau::tracking
