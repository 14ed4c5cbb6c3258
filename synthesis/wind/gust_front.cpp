#include "synthesis/wind/gust_front.h"

#include <cmath>
#include <numbers>

#include "synthesis/wind/mean_wind.h"

namespace roseau::synthesis {

GustFronts::GustFronts(const std::vector<GustFront>& gusts) {
  for (const GustFront& gust : gusts) {
    ROSEAU_CHECK(gust.speed_mps > 0 && gust.length_m > 0);
    fronts_.push_back({gust, towards_from_direction(gust.direction_from_deg)});
  }
}

Vec3 GustFronts::velocity_mps(const Vec3& point_in_world, double time_s) const {
  Vec3 sum;
  for (const auto& [gust, along] : fronts_) {
    const double ahead_m = point_in_world.x * along.x + point_in_world.y * along.y;
    const double passed = (gust.speed_mps * (time_s - gust.start_s) - ahead_m) / gust.length_m;  // share of the length
    if (passed <= 0) continue;
    if (passed >= 1 && gust.shape == GustShape::one_minus_cos) continue;
    const double turns = gust.shape == GustShape::one_minus_cos ? passed : std::fmin(passed, 1) / 2;
    const double speed_mps = gust.amplitude_mps * 0.5 * (1 - std::cos(2 * std::numbers::pi * turns));
    sum = {sum.x + speed_mps * along.x, sum.y + speed_mps * along.y, sum.z};
  }
  return sum;
}

}  // namespace roseau::synthesis
