// Patch: the small piece of picture that a feature is recognised by, cut from its reference frame and found again in later
// frames to a fraction of a pixel. Because every frame is compared with the same reference, errors do not add up.
//
// Method: inverse compositional alignment (Baker and Matthews) of a translation, with brightness and contrast projected
// out, so that a change of light neither biases nor breaks the match. Pixel coordinates here have their origin at the
// CENTRE of the upper left pixel, as OpenCV's.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>

namespace roseau::tracking {

/// Index of a pixel in rows of `stride`.
constexpr std::size_t pixel_index(int row, int column, int stride) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(stride) + static_cast<std::size_t>(column);
}

struct PatchMatch {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // px
  double correlation = 0;  // normalised cross-correlation there, -1..1; brightness and contrast do not matter
  bool found = false;      // converged inside the picture; the caller judges `correlation`
};

class Patch {
 public:
  static constexpr int kSide = 15;          // px compared
  static constexpr int kReach = kSide / 2;  // px from the centre
  static constexpr int kCut = kSide + 2;    // px kept: one more on each side, for the gradient
  using Pixels = std::array<std::uint8_t, std::size_t{kCut} * kCut>;

  /// Nothing when the cut would leave the picture or when it has too little texture in some direction to be found again.
  static std::optional<Patch> cut(const cv::Mat& gray, int centre_x, int centre_y);
  /// From kept pixels (a checkpoint); nothing where they could not have come from cut().
  static std::optional<Patch> from_pixels(const Pixels& pixels);

  /// Searches from `start`, at most `most_shift` px away from it. `warp` maps offsets in the reference to offsets in this
  /// picture (rotation, stretch), so that a turning branch is still recognised.
  PatchMatch align(const cv::Mat& gray, const Eigen::Vector2d& start, const Eigen::Matrix2d& warp, double most_shift) const;

  const Pixels& pixels() const { return pixels_; }

 private:
  // Rows of 16 so that the inner loops run in whole vector registers; the sixteenth column has weight zero.
  static constexpr int kStride = 16;
  using Plane = std::array<float, std::size_t{kSide} * kStride>;
  struct Sums;

  bool prepare();
  Sums sums_shifted(const cv::Mat& gray, const Eigen::Vector2d& centre) const;
  Sums sums_warped(const cv::Mat& gray, const Eigen::Vector2d& centre, const Eigen::Matrix2d& warp) const;
  Sums sums_of(const Plane& picture) const;

  Pixels pixels_{};
  alignas(16) Plane texture_{};    // zero mean
  alignas(16) Plane descent_x_{};  // gradient with brightness and contrast projected out
  alignas(16) Plane descent_y_{};
  Eigen::Matrix2d inverse_hessian_ = Eigen::Matrix2d::Zero();
  double texture_energy_ = 0;  // sum of squares of texture_
};

}  // namespace roseau::tracking
