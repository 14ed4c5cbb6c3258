// Landscape: what lies behind the tree as far as the sky: clouds, hills, a wood, a meadow. Painted per ray, so that two
// cameras see the same place, each from where it stands.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "core/sample.h"

namespace roseau::synthesis {

/// CV_8UC3 (blue, green, red) of the camera's size.
cv::Mat paint_landscape(const CameraCalibration& camera, std::uint64_t seed);

}  // namespace roseau::synthesis
