// Robust mean of many two-dimensional measurements of one motion: the mean shift of the plant thesis, 2.5.2, as corrected
// in docs/errata.md. The measurements are taken as draws from a density whose highest mode is wanted; outliers, however
// many and wherever they are, do not pull at it as long as they do not form the denser cluster.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace roseau::tracking {

struct MeanShiftOptions {
  /// Standard deviation (in the measurements' unit) below which the kernel is not narrowed: measurement noise of one draw.
  /// Without such a floor the covariance goes to zero around whichever draw is nearest.
  double kernel_floor = 0.05;
  /// The kernel is not narrowed either when it would rest on fewer draws than this share of all.
  double least_share = 0.35;
  int most_iterations = 30;
};

struct RobustMean {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();        // of the agreeing draws
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // scatter of one agreeing draw, floor included
  std::vector<char> agrees;                              // per draw, in the order given
  int agreeing = 0;
  bool found = false;  // false: fewer than three draws
};

/// Kernel density estimate of the thesis at x for a kernel of the given covariance, unnormalised by its determinant:
/// (1/n) sum exp(-1/2 |x_i - x|^2_Mahalanobis).
double kernel_density(std::span<const Eigen::Vector2d> draws, const Eigen::Vector2d& x, const Eigen::Matrix2d& covariance);

/// One corrected step: kernel weights about x, their weighted mean as the new x, and the unbiased weighted covariance
/// centred on the old x. Exposed for the proof of the erratum.
struct MeanShiftStep {
  Eigen::Vector2d x;
  Eigen::Matrix2d covariance;
  double effective_draws = 0;  // 1 / sum of squared normalised weights
};
MeanShiftStep mean_shift_step(std::span<const Eigen::Vector2d> draws, const Eigen::Vector2d& x,
                              const Eigen::Matrix2d& kernel_covariance);

/// Finds the mode with the narrowing kernel, lets the kernel grow back to the size of the cluster that it found, and takes
/// mean and scatter of the draws inside (Mahalanobis distance of a 99 % ellipse). Result reused to avoid allocation.
void robust_mean(std::span<const Eigen::Vector2d> draws, const MeanShiftOptions& options, RobustMean& result);

/// Squared Mahalanobis radius that holds 99 % of a two-dimensional normal distribution.
inline constexpr double kAgreeDistance2 = 9.2103;

/// Squared Mahalanobis distance of `offset`.
double mahalanobis2(const Eigen::Vector2d& offset, const Eigen::Matrix2d& inverse_covariance);

}  // namespace roseau::tracking
