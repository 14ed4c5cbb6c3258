// What tracking can be told. Lengths are pixels of the frame as received.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/geometry.h"
#include "core/result.h"

namespace roseau::tracking {

/// One camera's targets are told apart by one byte, of which one value means background.
inline constexpr std::size_t kMostTargets = 254;

struct TargetRegion {
  std::string name;  // becomes part of a topic: letters, digits, '-', '_' and '.'
  ImageRect region;  // in the first frame
};

struct TrackerOptions {
  std::vector<TargetRegion> targets;
  /// With no targets given and none added by the operator: watch the picture and choose what moves.
  bool automatic_targets = true;
  int automatic_frames = 60;  // how long to watch before choosing; again until something moved
  int automatic_most_targets = 4;
  double automatic_least_motion_px = 0.15;  // RMS about the mean below which a point counts as static

  int feature_count = 500;          // all points of one camera, background included
  double background_share = 0.3;    // of feature_count, once there are targets
  bool subtract_background = true;  // take the camera's own motion, seen by the background points, off every target

  int pyramid_levels = 3;    // halvings above the full picture; each doubles the motion that can be followed
  int window_px = 17;        // side of the flow's window
  int flow_iterations = 10;  // at most, per level
  double flow_converged_px = 0.03;
  double forward_backward_px = 0.7;  // a point that comes back further away than this is not trusted

  double least_correlation = 0.75;         // with a point's reference patch, for it to count as seen
  double search_radius_px = 48;            // how far from its last place a lost target is looked for
  double standard_error_floor_px = 0.005;  // no displacement is claimed to be better known than this

  int mono16_significant_bits = 0;  // 9 to 16; 0: from the first frame
};

/// An Error names the option, its value and what it may be.
Result<void> validate(const TrackerOptions& options);

/// Usable as a part of a topic: not empty, at most 64 letters, digits, '-', '_' and '.'.
bool is_target_name(std::string_view name);

}  // namespace roseau::tracking
