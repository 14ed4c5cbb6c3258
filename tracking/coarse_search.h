// Coarse search: where a lost region has gone, by box matching of its points' coarse patches (the plant thesis, 2.5.1: box
// matching in a pyramid). Every point votes with its correlation for every shift; points of one region vote for the same.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <span>

#include "tracking/patch.h"

namespace roseau::tracking {

struct CoarseProbe {
  const Patch* patch = nullptr;
  Eigen::Vector2i expected{0, 0};  // centre for zero shift, px of `gray`
};

struct CoarseShift {
  Eigen::Vector2i shift{0, 0};  // px of `gray`
  double correlation = -1;      // mean over the probes
};

/// The shift within `radius` px in either direction with the greatest mean correlation; the first of equals in reading
/// order. Probes that would leave the picture count as zero there.
CoarseShift coarse_search(const cv::Mat& gray, std::span<const CoarseProbe> probes, int radius);

}  // namespace roseau::tracking
