#include "tracking/patch.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace roseau::tracking {

namespace {

constexpr int kMostIterations = 12;
constexpr double kConverged = 0.003;  // px per iteration
constexpr double kNearlyConverged = 0.03;
// Smallest eigenvalue of the gradient matrix per pixel, in grey levels^2 per px^2: below, sensor noise decides the match.
constexpr double kLeastTexture = 4;
// A warp that moves no pixel of the patch by more than this leaves the translation where it is, and costs a third.
constexpr double kWorthWarping = 0.1;  // px

constexpr double kPixels = Patch::kSide * Patch::kSide;

/// Lagrange's cubic through four neighbours, at `fraction` between the middle two. Linear interpolation (and Catmull and
/// Rom's cubic just as much) draws fine texture by a hundredth of a pixel towards the nearer pixel; this one by a fifth of it.
std::array<float, 4> cubic_weights(float fraction) {
  const float f = fraction;
  return {-f * (f - 1) * (f - 2) / 6, (f + 1) * (f - 1) * (f - 2) / 2, -(f + 1) * f * (f - 2) / 2, (f + 1) * f * (f - 1) / 6};
}

}  // namespace

struct Patch::Sums {
  double mean = 0;
  double energy = 0;   // of the picture's pixels about their mean
  double product = 0;  // with texture
  double along_x = 0;  // with descent
  double along_y = 0;
};

std::optional<Patch> Patch::cut(const cv::Mat& gray, int centre_x, int centre_y) {
  constexpr int kMargin = kReach + 1;
  if (centre_x < kMargin || centre_y < kMargin || centre_x + kMargin >= gray.cols || centre_y + kMargin >= gray.rows) {
    return std::nullopt;
  }
  Patch patch;
  for (int row = 0; row < kCut; ++row) {
    const std::uint8_t* from = gray.ptr<std::uint8_t>(centre_y - kMargin + row) + centre_x - kMargin;
    std::copy_n(from, kCut, patch.pixels_.begin() + row * kCut);
  }
  if (!patch.prepare()) return std::nullopt;
  return patch;
}

std::optional<Patch> Patch::from_pixels(const Pixels& pixels) {
  Patch patch;
  patch.pixels_ = pixels;
  if (!patch.prepare()) return std::nullopt;
  return patch;
}

bool Patch::prepare() {
  const auto pixel = [this](int row, int column) {
    return static_cast<float>(pixels_[pixel_index(row + 1, column + 1, kCut)]);
  };
  double mean = 0;
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) mean += pixel(row, column);
  }
  mean /= kPixels;

  double mean_x = 0;
  double mean_y = 0;
  double with_x = 0;
  double with_y = 0;
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const auto at = pixel_index(row, column, kStride);
      texture_[at] = pixel(row, column) - static_cast<float>(mean);
      descent_x_[at] = 0.5F * (pixel(row, column + 1) - pixel(row, column - 1));
      descent_y_[at] = 0.5F * (pixel(row + 1, column) - pixel(row - 1, column));
      texture_energy_ += static_cast<double>(texture_[at]) * texture_[at];
      mean_x += descent_x_[at] / kPixels;
      mean_y += descent_y_[at] / kPixels;
      with_x += static_cast<double>(descent_x_[at]) * texture_[at];
      with_y += static_cast<double>(descent_y_[at]) * texture_[at];
    }
  }
  if (!(texture_energy_ > kLeastTexture * kPixels)) return false;

  // Taking out the parts along "brighter" and "more contrast" makes the step blind to both.
  Eigen::Matrix2d hessian = Eigen::Matrix2d::Zero();
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const auto at = pixel_index(row, column, kStride);
      descent_x_[at] -= static_cast<float>(mean_x + with_x / texture_energy_ * texture_[at]);
      descent_y_[at] -= static_cast<float>(mean_y + with_y / texture_energy_ * texture_[at]);
      const Eigen::Vector2d descent(descent_x_[at], descent_y_[at]);
      hessian += descent * descent.transpose();
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(hessian, Eigen::EigenvaluesOnly);
  if (!(eigen.eigenvalues()[0] > kLeastTexture * kPixels)) return false;
  inverse_hessian_ = hessian.inverse();
  return true;
}

Patch::Sums Patch::sums_of(const Plane& picture) const {
  // Sixteen lanes added up separately, then in fixed order: vector code whose result does not depend on the compiler.
  std::array<float, kStride> sum{};
  std::array<float, kStride> energy{};
  std::array<float, kStride> product{};
  std::array<float, kStride> along_x{};
  std::array<float, kStride> along_y{};
  for (std::size_t row = 0; row < kSide; ++row) {
    const float* value = picture.data() + row * kStride;
    const float* texture = texture_.data() + row * kStride;
    const float* descent_x = descent_x_.data() + row * kStride;
    const float* descent_y = descent_y_.data() + row * kStride;
    for (std::size_t lane = 0; lane < kStride; ++lane) {
      sum[lane] += value[lane];
      energy[lane] += value[lane] * value[lane];
      product[lane] += value[lane] * texture[lane];
      along_x[lane] += value[lane] * descent_x[lane];
      along_y[lane] += value[lane] * descent_y[lane];
    }
  }
  Sums sums;
  for (std::size_t lane = 0; lane < kStride; ++lane) {
    sums.mean += sum[lane];
    sums.energy += energy[lane];
    sums.product += product[lane];
    sums.along_x += along_x[lane];
    sums.along_y += along_y[lane];
  }
  sums.mean /= kPixels;
  sums.energy -= kPixels * sums.mean * sums.mean;
  return sums;
}

Patch::Sums Patch::sums_shifted(const cv::Mat& gray, const Eigen::Vector2d& centre) const {
  const double left = std::floor(centre.x());
  const double top = std::floor(centre.y());
  const std::array<float, 4> weight_x = cubic_weights(static_cast<float>(centre.x() - left));
  const std::array<float, 4> weight_y = cubic_weights(static_cast<float>(centre.y() - top));
  const int first_x = static_cast<int>(left) - kReach - 1;
  const int first_y = static_cast<int>(top) - kReach - 1;

  // Every row is interpolated along x once and used four times. 128 is taken off so that sums of squares keep their digits.
  constexpr int kRead = kStride + 3;
  alignas(16) Plane picture;
  alignas(16) std::array<std::array<float, kStride>, kSide + 3> rows;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const std::uint8_t* from = gray.ptr<std::uint8_t>(first_y + static_cast<int>(row)) + first_x;
    std::array<float, kRead> raw;
    for (std::size_t column = 0; column < kRead; ++column) raw[column] = static_cast<float>(from[column]) - 128.0F;
    for (std::size_t column = 0; column < kStride; ++column) {
      rows[row][column] = weight_x[0] * raw[column] + weight_x[1] * raw[column + 1] + weight_x[2] * raw[column + 2] +
                          weight_x[3] * raw[column + 3];
    }
    rows[row][kStride - 1] = 0;
  }
  for (std::size_t row = 0; row < kSide; ++row) {
    for (std::size_t column = 0; column < kStride; ++column) {
      picture[row * kStride + column] = weight_y[0] * rows[row][column] + weight_y[1] * rows[row + 1][column] +
                                        weight_y[2] * rows[row + 2][column] + weight_y[3] * rows[row + 3][column];
    }
  }
  return sums_of(picture);
}

Patch::Sums Patch::sums_warped(const cv::Mat& gray, const Eigen::Vector2d& centre, const Eigen::Matrix2d& warp) const {
  alignas(16) Plane picture{};
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const Eigen::Vector2d at = centre + warp * Eigen::Vector2d(column - kReach, row - kReach);
      const int x = static_cast<int>(at.x());
      const int y = static_cast<int>(at.y());
      const auto fraction_x = static_cast<float>(at.x() - x);
      const auto fraction_y = static_cast<float>(at.y() - y);
      const std::uint8_t* upper = gray.ptr<std::uint8_t>(y) + x;
      const std::uint8_t* lower = gray.ptr<std::uint8_t>(y + 1) + x;
      const float above = static_cast<float>(upper[0]) + fraction_x * static_cast<float>(upper[1] - upper[0]);
      const float below = static_cast<float>(lower[0]) + fraction_x * static_cast<float>(lower[1] - lower[0]);
      picture[pixel_index(row, column, kStride)] = above + fraction_y * (below - above) - 128.0F;
    }
  }
  return sums_of(picture);
}

PatchMatch Patch::align(const cv::Mat& gray, const Eigen::Vector2d& start, const Eigen::Matrix2d& warp,
                        double most_shift) const {
  const double corner = (warp - Eigen::Matrix2d::Identity()).cwiseAbs().rowwise().sum().maxCoeff() * kReach;
  const bool warped = corner > kWorthWarping;
  // Interpolation needs one or two pixels around the patch, and reading sixteen columns at a time takes one more.
  const double margin = kReach + 3 + (warped ? corner : 0);
  const auto inside = [&](const Eigen::Vector2d& at) {
    return at.x() >= margin && at.y() >= margin && at.x() < gray.cols - 1 - margin && at.y() < gray.rows - 1 - margin;
  };

  PatchMatch match{start, 0, false};
  double last_step = most_shift;
  for (int i = 0; i < kMostIterations; ++i) {
    if (!inside(match.position)) return match;
    const Sums sums = warped ? sums_warped(gray, match.position, warp) : sums_shifted(gray, match.position);
    if (!(sums.energy > kPixels)) return match;  // nothing there but one grey level
    match.correlation = sums.product / std::sqrt(sums.energy * texture_energy_);
    // The picture's contrast relative to the reference's; the descent images are orthogonal to brightness and texture, so
    // the error image need not be formed.
    const double contrast = std::sqrt(texture_energy_ / sums.energy);
    const Eigen::Vector2d step = warp * (inverse_hessian_ * Eigen::Vector2d(sums.along_x, sums.along_y)) * contrast;
    if (step.norm() < kConverged) {
      match.position -= step;
      match.found = true;
      return match;
    }
    match.position -= step;
    if ((match.position - start).norm() > most_shift) return match;
    last_step = step.norm();
  }
  // Coarse texture converges slowly but steadily: a small last step counts.
  match.found = last_step < kNearlyConverged && inside(match.position);
  return match;
}

}  // namespace roseau::tracking
