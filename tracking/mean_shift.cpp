#include "tracking/mean_shift.h"

#include <Eigen/LU>
#include <cmath>

namespace roseau::tracking {

namespace {

constexpr double kFewestDraws = 6;  // fewer fall close together by chance

Eigen::Matrix2d with_floor(const Eigen::Matrix2d& covariance, double floor) {
  return covariance + Eigen::Matrix2d::Identity() * (floor * floor);
}

/// Plain mean and covariance of all draws: where the search starts.
MeanShiftStep start_of(std::span<const Eigen::Vector2d> draws) {
  MeanShiftStep start{Eigen::Vector2d::Zero(), Eigen::Matrix2d::Zero(), static_cast<double>(draws.size())};
  for (const Eigen::Vector2d& draw : draws) start.x += draw;
  start.x /= start.effective_draws;
  for (const Eigen::Vector2d& draw : draws) start.covariance += (draw - start.x) * (draw - start.x).transpose();
  start.covariance /= start.effective_draws - 1;
  return start;
}

/// Narrows the kernel pass by pass towards the highest mode. Every pass shrinks the covariance (that of a normal cluster
/// seen through a kernel of its own size is half of it), so the narrowing ends at the floor or when too few draws carry it.
MeanShiftStep narrow_to_mode(std::span<const Eigen::Vector2d> draws, const MeanShiftOptions& options) {
  const double fewest = std::max(kFewestDraws, options.least_share * static_cast<double>(draws.size()));
  MeanShiftStep now = start_of(draws);
  for (int i = 0; i < options.most_iterations; ++i) {
    const Eigen::Matrix2d kernel = with_floor(now.covariance, options.kernel_floor);
    const MeanShiftStep next = mean_shift_step(draws, now.x, kernel);
    if (next.effective_draws < fewest) break;
    const bool settled =
        mahalanobis2(next.x - now.x, kernel.inverse()) < 1e-6 && next.covariance.trace() > 0.98 * now.covariance.trace();
    now = next;
    if (settled) break;
  }
  return now;
}

/// Lets the kernel grow from the mode to the cluster around it: doubling makes the weighted covariance that of the cluster
/// itself at the fixed point (S K / (S + K) = K / 2 for K = S). A gap around the cluster stops the growth.
MeanShiftStep grow_to_cluster(std::span<const Eigen::Vector2d> draws, const MeanShiftOptions& options, MeanShiftStep now,
                              double most_variance) {
  for (int i = 0; i < options.most_iterations; ++i) {
    MeanShiftStep next = mean_shift_step(draws, now.x, with_floor(now.covariance, options.kernel_floor));
    next.covariance *= 2;
    const double before = now.covariance.trace();
    const double after = next.covariance.trace();
    if (after > most_variance) break;
    now = next;
    if (std::abs(after - before) < 0.01 * before) break;
  }
  return now;
}

}  // namespace

double mahalanobis2(const Eigen::Vector2d& offset, const Eigen::Matrix2d& inverse_covariance) {
  return offset.dot(inverse_covariance * offset);
}

double kernel_density(std::span<const Eigen::Vector2d> draws, const Eigen::Vector2d& x, const Eigen::Matrix2d& covariance) {
  const Eigen::Matrix2d inverse = covariance.inverse();
  double sum = 0;
  for (const Eigen::Vector2d& draw : draws) sum += std::exp(-0.5 * mahalanobis2(draw - x, inverse));
  return sum / static_cast<double>(draws.size());
}

MeanShiftStep mean_shift_step(std::span<const Eigen::Vector2d> draws, const Eigen::Vector2d& x,
                              const Eigen::Matrix2d& kernel_covariance) {
  const Eigen::Matrix2d inverse = kernel_covariance.inverse();
  double weight_sum = 0;
  double weight2_sum = 0;
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& draw : draws) {
    const Eigen::Vector2d offset = draw - x;
    const double weight = std::exp(-0.5 * mahalanobis2(offset, inverse));
    weight_sum += weight;
    weight2_sum += weight * weight;
    first += weight * offset;
    second += weight * offset * offset.transpose();
  }
  if (!(weight_sum > 0)) return {x, kernel_covariance, 0};
  const double share2 = weight2_sum / (weight_sum * weight_sum);
  // Unbiased: the thesis divides by (sum w)^2 - sum w^2 with normalised w, which is 1 - share2.
  const double unbias = 1 - share2 > 1e-9 ? 1 / (1 - share2) : 0;
  return {x + first / weight_sum, second / weight_sum * unbias, 1 / share2};
}

void robust_mean(std::span<const Eigen::Vector2d> draws, const MeanShiftOptions& options, RobustMean& result) {
  result.agrees.assign(draws.size(), 0);
  result.agreeing = 0;
  result.found = draws.size() >= 3;
  if (!result.found) return;

  const MeanShiftStep mode = narrow_to_mode(draws, options);
  const MeanShiftStep cluster =
      grow_to_cluster(draws, options, mode, with_floor(start_of(draws).covariance, options.kernel_floor).trace());
  const Eigen::Matrix2d inverse = with_floor(cluster.covariance, options.kernel_floor).inverse();

  result.mean.setZero();
  result.covariance.setZero();
  for (std::size_t i = 0; i < draws.size(); ++i) {
    if (mahalanobis2(draws[i] - cluster.x, inverse) > kAgreeDistance2) continue;
    result.agrees[i] = 1;
    ++result.agreeing;
    result.mean += draws[i];
  }
  result.found = result.agreeing >= 3;
  if (!result.found) return;
  result.mean /= result.agreeing;
  for (std::size_t i = 0; i < draws.size(); ++i) {
    if (result.agrees[i] == 0) continue;
    const Eigen::Vector2d offset = draws[i] - result.mean;
    result.covariance += offset * offset.transpose() / (result.agreeing - 1);
  }
  result.covariance = with_floor(result.covariance, options.kernel_floor);
}

}  // namespace roseau::tracking
