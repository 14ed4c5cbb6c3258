// WindField: the air's velocity anywhere, at any time. Implemented by synthesis (turbulence, gusts, a recorded sonic);
// used by the simulated rig's structures and instruments.
#pragma once

#include <cstddef>
#include <span>

#include "core/check.h"
#include "core/geometry.h"

namespace roseau {

class WindField {
 public:
  virtual ~WindField() = default;

  /// Velocity of the air in m/s, in the world frame (x east, y north, z up), at a point in metres and a time in seconds
  /// since the field's own start. Pure: the same arguments give the same velocity. Safe to call from several threads.
  virtual Vec3 velocity_mps(const Vec3& point_in_world, double time_s) const = 0;

  /// The same at many points at one time, which fields do faster than point by point; `out` has as many elements as the
  /// points and does not overlap them. What one point gets does not depend on the other points.
  virtual void velocities_mps(std::span<const Vec3> points_in_world, double time_s, std::span<Vec3> out) const {
    ROSEAU_CHECK(out.size() == points_in_world.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = velocity_mps(points_in_world[i], time_s);
  }
};

}  // namespace roseau
