// GustFront: a single gust that crosses the site as a straight front, on top of whatever else blows.
//
//   one_minus_cos   0 before and after, (1 - cos)/2 over its length (the discrete gust of aircraft and wind turbine rules)
//   ramp            rises as (1 - cos)/2 over its length and stays
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/wind_field.h"

namespace roseau::synthesis {

enum class GustShape : std::uint8_t { one_minus_cos, ramp };

constexpr std::string_view to_string(GustShape shape) { return shape == GustShape::one_minus_cos ? "one_minus_cos" : "ramp"; }

struct GustFront {
  GustShape shape = GustShape::one_minus_cos;
  double amplitude_mps = 4;         // the highest addition to the wind, along the gust's own direction; below 0: a lull
  double direction_from_deg = 270;  // where it comes from and where it blows from, clockwise from north
  double speed_mps = 6;             // of the front across the site
  double length_m = 30;             // from its foremost edge to its end (one_minus_cos) or its full strength (ramp)
  double start_s = 10;              // when the foremost edge reaches the world's origin
};

class GustFronts final : public WindField {
 public:
  explicit GustFronts(const std::vector<GustFront>& gusts);

  Vec3 velocity_mps(const Vec3& point_in_world, double time_s) const override;

 private:
  struct Front {
    GustFront gust;
    Vec3 along;
  };
  std::vector<Front> fronts_;
};

}  // namespace roseau::synthesis
