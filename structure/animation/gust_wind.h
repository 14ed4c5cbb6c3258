// GustWind: a procedural wind over a forest, the "procedural equation" of the thesis's Figure 6.6: a mean wind and plane waves
// of gusts that it carries along (frozen turbulence, 5.5). The same everywhere along z. Made for thousands of trees per frame;
// the physical wind of the rig is synthesis's.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/wind_field.h"

namespace roseau::structure {

/// One plane wave: wind along and across the mean wind, sine of (wave number x (point - mean wind x time) + phase).
struct Gust {
  double wavelength_m = 0;
  double direction_rad = 0;  // of the wave number, from the mean wind, counter-clockwise seen from above
  double phase_rad = 0;
  double along_mps = 0;
  double across_mps = 0;
};

class GustWind final : public WindField {
 public:
  GustWind(const Vec3& mean_mps, std::span<const Gust> gusts);

  /// Gusts from 20 to 200 m long whose standard deviation along the mean wind is `intensity` times the mean speed, half of that
  /// across it. `count` waves, the same ones every time.
  static GustWind with_intensity(const Vec3& mean_mps, double intensity, std::size_t count = 6);

  Vec3 velocity_mps(const Vec3& point_in_world, double time_s) const override;
  /// Single precision inside: about 1e-5 of the gusts' speed within a kilometre of the origin.
  void velocities_mps(std::span<const Vec3> points_in_world, double time_s, std::span<Vec3> out) const override;

 private:
  struct Wave {
    double east_per_m;
    double north_per_m;
    double per_s;  // how fast the phase falls at a fixed point
    double phase_rad;
    double along_mps;
    double across_mps;
  };

  void add_gusts(std::span<const Vec3> points_in_world, double time_s, std::span<Vec3> velocities_mps) const;

  Vec3 mean_mps_;
  Vec3 along_;  // horizontal unit vector of the mean wind
  std::vector<Wave> waves_;
};

}  // namespace roseau::structure
