// How the branch bends: every point of it is displaced along x by the top's deflection times a gain that grows with height.
#pragma once

#include <algorithm>

namespace roseau::synthesis {

/// Fractions of the branch's height between root and top: the stem bends like a cantilever (gain ~ height^2) up to
/// kBendEnd, straightens out, and from kStiffBegin on the leafy top moves as a whole. So all points of the target share one
/// displacement, and its truth is one number.
inline constexpr double kBendEnd = 0.42;
inline constexpr double kStiffBegin = 0.62;

/// Gain at a relative height (0 = root, 1 = top): 0 below the root, continuous with its slope, 1 on the leafy top.
constexpr double bending_gain(double relative_height) {
  const double s = std::clamp(relative_height, 0.0, kStiffBegin);
  if (s <= kBendEnd) return s * s / (kBendEnd * kStiffBegin);
  return 1 - (kStiffBegin - s) * (kStiffBegin - s) / (kStiffBegin * (kStiffBegin - kBendEnd));
}

}  // namespace roseau::synthesis
