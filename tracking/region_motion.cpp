#include "tracking/region_motion.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "tracking/patch.h"

namespace roseau::tracking {

namespace {

constexpr int kRefinements = 3;
constexpr double kNoiseCounts = 3;      // points
constexpr double kTruncation = 0.9535;  // variance of a normal distribution inside its 99 % ellipse
// How far turning and stretching may be off what was expected: keeps the gradient there in directions that the points do
// not span (half of the region hidden), and is forgotten where they do.
constexpr double kGradientSd = 0.02;

/// Neighbouring points look at the same pixels, so they do not err independently: no more points are counted as
/// independent than patches fit side by side over the area they cover.
double independent_points(std::span<const RegionPoint> points, std::span<const char> agrees, int agreeing) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9);
  Eigen::Vector2d high = -low;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (agrees[i] == 0) continue;
    low = low.cwiseMin(points[i].offset);
    high = high.cwiseMax(points[i].offset);
  }
  const Eigen::Vector2d patches = ((high - low).array() / Patch::kSide + 1).matrix();
  return std::min(static_cast<double>(agreeing), patches.x() * patches.y());
}

}  // namespace

void RegionFitter::least_squares(std::span<const RegionPoint> points, const Eigen::Matrix2d& expected) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (fit_.agrees[i] == 0) continue;
    const Eigen::Vector3d row(1, points[i].offset.x(), points[i].offset.y());
    normal += row * row.transpose();
    right += row * (points[i].displacement - expected * points[i].offset).transpose();
  }
  const double ridge = fit_.variance / (kGradientSd * kGradientSd);
  normal(1, 1) += ridge;
  normal(2, 2) += ridge;
  inverse_normal_ = normal.inverse();
  const Eigen::Matrix<double, 3, 2> solution = inverse_normal_ * right;
  fit_.motion.displacement = solution.row(0).transpose();
  fit_.motion.gradient = expected + solution.bottomRows<2>().transpose();
}

/// Marks who agrees with the fitted motion, by a scale from the median distance of those that did.
void RegionFitter::agree_within(std::span<const RegionPoint> points, double noise_px) {
  distances2_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (fit_.agrees[i] != 0) {
      distances2_.push_back((points[i].displacement - fit_.motion.at(points[i].offset)).squaredNorm());
    }
  }
  const auto middle = distances2_.begin() + static_cast<std::ptrdiff_t>(distances2_.size() / 2);
  std::nth_element(distances2_.begin(), middle, distances2_.end());
  // The median of a squared distance in two dimensions is 2 ln 2 times the variance of a coordinate.
  fit_.variance = std::max(noise_px * noise_px, *middle / (2 * std::log(2.0)));
  fit_.agreeing = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    fit_.agrees[i] = fit_.holds_for(points[i]) ? 1 : 0;
    fit_.agreeing += fit_.agrees[i];
  }
}

const RegionFit& RegionFitter::fit(std::span<const RegionPoint> points, const Eigen::Matrix2d& expected, double noise_px) {
  draws_.clear();
  for (const RegionPoint& point : points) draws_.push_back(point.displacement - expected * point.offset);
  MeanShiftOptions options;
  options.kernel_floor = noise_px;
  robust_mean(draws_, options, mode_);
  fit_.found = mode_.found;
  fit_.agrees = mode_.agrees;
  fit_.agreeing = mode_.agreeing;
  if (!fit_.found) return fit_;

  fit_.variance = 0.5 * mode_.covariance.trace();
  for (int i = 0; i < kRefinements; ++i) {
    least_squares(points, expected);
    agree_within(points, noise_px);
    if (fit_.agreeing < 3) {
      fit_.found = false;
      return fit_;
    }
  }
  least_squares(points, expected);

  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (fit_.agrees[i] == 0) continue;
    const Eigen::Vector2d residual = points[i].displacement - fit_.motion.at(points[i].offset);
    scatter += residual * residual.transpose();
  }
  // Three numbers were fitted per coordinate. A handful of points may still lie on the plane by luck, so the noise that
  // every point has counts as a few more.
  scatter += Eigen::Matrix2d::Identity() * (kNoiseCounts * noise_px * noise_px);
  scatter /= (fit_.agreeing - 3 + kNoiseCounts) * kTruncation;
  const double overlap = fit_.agreeing / independent_points(points, fit_.agrees, fit_.agreeing);
  fit_.covariance = scatter * inverse_normal_(0, 0) * overlap;
  return fit_;
}

}  // namespace roseau::tracking
