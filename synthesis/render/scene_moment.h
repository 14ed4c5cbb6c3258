// The state of the scene at one time: everything in it that moves or changes.
#pragma once

#include <functional>
#include <vector>

#include "core/geometry.h"

namespace roseau::render {

/// The calibration rig at one time. Bars are chains of points (two for a straight one, more for one that sags).
struct RigMoment {
  bool visible = false;
  Quaternion world_from_rig;
  std::vector<Vec3> targets_in_world_m;  // centres of the tags' black squares, one per tag of BarRig::front_tags
  std::vector<Vec3> long_bar_in_world_m;
  std::vector<Vec3> cross_bar_in_world_m;
};

struct SceneMoment {
  /// Per node of the tree, in world axes: how far it is from its place at rest, and the rotation vector it has turned by.
  /// Leaves and balls move rigidly with their node.
  std::vector<Vec3> displacement_m;
  std::vector<Vec3> rotation_rad;
  double board_time_s = 0;     // the LED board's clock; its tick 0 begins at 0
  double light_level = 1;      // daylight; 1 = what the colours are meant for
  double background_sway = 1;  // how strongly hedge and grass move
  RigMoment rig;
};

/// Fills in the state at a time. The vectors come with one element per node, zero at first, and keep what was last filled in.
using MomentAt = std::function<void(double time_s, SceneMoment& moment)>;

}  // namespace roseau::render
