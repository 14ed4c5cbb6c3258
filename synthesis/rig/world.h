// World: what all devices of a rig observe. Immutable, shared by their threads.
#pragma once

#include <memory>

#include "synthesis/oscillator/branch_motion.h"
#include "synthesis/scene.h"
#include "synthesis/wind/turbulent_wind.h"

namespace roseau::synthesis {

struct World {
  explicit World(const Scene& its_scene);

  Scene scene;
  Vec3 drag_point;  // where the wind moves the branch: the middle of its leafy top
  std::shared_ptr<const TurbulentWind> wind;

  /// A branch motion of one's own: each device steps its own, and all are the same.
  BranchMotion branch_motion() const;

  /// The air's velocity at a point in the sonic's axes: what a perfect instrument mounted as the scene's would show.
  WindSample wind_in_sonic_axes(const Vec3& point_in_world, double time_s) const;
};

}  // namespace roseau::synthesis
