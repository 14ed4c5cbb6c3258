// World: what all devices of a rig observe. Immutable, shared by their threads.
#pragma once

#include <memory>

#include "synthesis/instruments/surroundings.h"
#include "synthesis/oscillator/branch_motion.h"
#include "synthesis/scene.h"
#include "synthesis/wind/turbulent_wind.h"

namespace roseau::synthesis {

struct World : Surroundings {
  explicit World(const Scene& its_scene);

  Vec3 wind_mps(const Vec3& point_in_world_m, double time_s) const override {
    return wind->velocity_mps(point_in_world_m, time_s);
  }
  /// There are no stations in this world: all are at its origin.
  StationPlace station_place(std::size_t, double) const override { return {}; }

  Scene scene;
  Vec3 drag_point;  // where the wind moves the branch: the middle of its leafy top
  std::shared_ptr<const TurbulentWind> wind;

  /// A branch motion of one's own: each device steps its own, and all are the same.
  BranchMotion branch_motion() const;

  /// The air's velocity at a point in the sonic's axes: what a perfect instrument mounted as the scene's would show.
  WindSample wind_in_sonic_axes(const Vec3& point_in_world, double time_s) const;
};

}  // namespace roseau::synthesis
