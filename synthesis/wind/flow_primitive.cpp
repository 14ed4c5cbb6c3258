#include "synthesis/wind/flow_primitive.h"

#include <cmath>
#include <numbers>

namespace roseau::synthesis {

FlowPrimitives::FlowPrimitives(std::vector<FlowPrimitive> primitives, const Vec3& drift_mps)
    : primitives_(std::move(primitives)), drift_mps_(drift_mps) {
  for (const FlowPrimitive& primitive : primitives_) {
    ROSEAU_CHECK(primitive.kind == FlowKind::uniform || primitive.core_radius_m > 0);
  }
}

namespace {
// (1 - exp(-r^2 / r_c^2)) / (2 pi r^2) times the strength: what multiplies the vector from the axis, or its normal.
double rate_per_s(const FlowPrimitive& primitive, double x_m, double y_m) {
  const double core2 = primitive.core_radius_m * primitive.core_radius_m;
  const double reduced = (x_m * x_m + y_m * y_m) / core2;
  const double shape = reduced > 1e-12 ? -std::expm1(-reduced) / reduced : 1;
  return primitive.strength_m2ps * shape / (2 * std::numbers::pi * core2);
}
}  // namespace

Vec3 FlowPrimitives::velocity_mps(const Vec3& point_in_world, double time_s) const {
  Vec3 sum;
  for (const FlowPrimitive& primitive : primitives_) {
    if (primitive.kind == FlowKind::uniform) {
      sum = {sum.x + primitive.velocity_mps.x, sum.y + primitive.velocity_mps.y, sum.z + primitive.velocity_mps.z};
      continue;
    }
    const double carried_s = primitive.drifts_with_wind ? time_s : 0;
    const double x = point_in_world.x - primitive.centre_in_world_m.x - drift_mps_.x * carried_s;
    const double y = point_in_world.y - primitive.centre_in_world_m.y - drift_mps_.y * carried_s;
    const double rate = rate_per_s(primitive, x, y);
    if (primitive.kind == FlowKind::vortex) {
      sum = {sum.x - rate * y, sum.y + rate * x, sum.z};
    } else {
      sum = {sum.x + rate * x, sum.y + rate * y, sum.z};
    }
  }
  return sum;
}

}  // namespace roseau::synthesis
