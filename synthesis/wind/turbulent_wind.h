// TurbulentWind: a mean wind with von Karman turbulence that drifts with it unchanged (Taylor's frozen flow, plant thesis
// equation 5.5).
//
// Along the mean wind the field is exact: what is at x now is at x + U dt in dt. Across it, the field is defined on
// "strands", lines parallel to the mean wind at given lateral positions, whose turbulence is coherent as
// exp(-decay sqrt(n^2 + (0.1 U / L)^2) d / U) over a distance d at frequency n (Davenport's form with a finite value at
// n = 0). On a strand the spectrum is the stated one; between two strands the velocity is interpolated linearly, which
// loses some of what the two do not share. So give one strand per instrument and structure. Turbulence does not change with
// height; the mean wind may.
//
// Periodic in time: kPeriodS (68 min), which keeps a rig that runs for days in a few megabytes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/wind_field.h"

namespace roseau::synthesis {

struct TurbulentWindOptions {
  double mean_speed_mps = 4;
  double direction_from_deg = 270;    // where the wind comes from, clockwise from north
  double turbulence_intensity = 0.3;  // sd along / mean speed
  double across_sd_ratio = 0.8;       // sd of the horizontal component across / sd along
  double vertical_sd_ratio = 0.5;     // sd of the vertical component / sd along
  double length_scale_m = 30;         // of the component along
  double across_length_scale_m = 15;  // of the components across (half of it in isotropic turbulence)
  double lateral_decay = 10;          // see above; 8 to 12 is usual over open country
  double reference_height_m = 2.6;    // where the mean is mean_speed_mps
  double profile_exponent = 0;        // mean ~ (height / reference)^exponent; 0 = the same at all heights
};

class TurbulentWind final : public WindField {
 public:
  static constexpr double kPeriodS = 4096;

  /// `points_in_world`: where strands are wanted (their lateral positions are taken); at least one.
  TurbulentWind(const TurbulentWindOptions& options, std::uint64_t seed, std::span<const Vec3> points_in_world);

  Vec3 velocity_mps(const Vec3& point_in_world, double time_s) const override;

  /// Unit vector of the mean wind's motion (towards), in the world's horizontal plane.
  Vec3 along() const { return along_; }

 private:
  // Fluctuations at one table time: along, across (left of along), up; padded so that one is a vector load.
  struct Gust {
    float along = 0;
    float across = 0;
    float up = 0;
    float unused = 0;
  };
  struct Strand {
    double lateral_m = 0;
    std::vector<Gust> gusts;
  };

  double lateral_m(const Vec3& point) const { return point.x * -along_.y + point.y * along_.x; }
  void make_component(float Gust::*component, std::uint64_t seed);
  static Vec3 gust_at(const Strand& strand, double table_position);

  TurbulentWindOptions options_;
  Vec3 along_;
  std::vector<Strand> strands_;  // ascending lateral position
};

}  // namespace roseau::synthesis
