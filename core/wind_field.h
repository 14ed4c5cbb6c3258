// WindField: the air's velocity anywhere, at any time. Implemented by synthesis (turbulence, gusts, a recorded sonic);
// used by the simulated rig's structures and instruments.
#pragma once

#include "core/geometry.h"

namespace roseau {

class WindField {
 public:
  virtual ~WindField() = default;

  /// Velocity of the air in m/s, in the world frame (x east, y north, z up), at a point in metres and a time in seconds
  /// since the field's own start. Pure: the same arguments give the same velocity. Safe to call from several threads.
  virtual Vec3 velocity_mps(const Vec3& point_in_world, double time_s) const = 0;
};

}  // namespace roseau
