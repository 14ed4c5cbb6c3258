// Surroundings: what instruments observe, as the rig's world gives it.
#pragma once

#include <cstddef>

#include "core/geometry.h"

namespace roseau::synthesis {

/// Where a tracker's station (receiver) is.
struct StationPlace {
  Vec3 position_in_world_m;
  Quaternion world_from_station;
};

/// Pure: the same arguments give the same answer. Safe to call from several threads. Times are the scene's, in seconds.
class Surroundings {
 public:
  virtual ~Surroundings() = default;

  /// Velocity of the air in the world's axes.
  virtual Vec3 wind_mps(const Vec3& point_in_world_m, double time_s) const = 0;

  /// `station`: the tracker's number, from 1.
  virtual StationPlace station_place(std::size_t station, double time_s) const = 0;

  /// Mean of the wind along the straight line between two points: what sound on its way sees.
  Vec3 path_mean_wind_mps(const Vec3& from_in_world_m, const Vec3& to_in_world_m, double time_s) const;
};

}  // namespace roseau::synthesis
