// FlowPrimitive: simple flows that solve the equations of air without friction, to be added up (Wejchert and Haumann 1991;
// plant thesis 5.2.2). Two-dimensional: the same at all heights.
//
//   uniform   one velocity everywhere
//   vortex    around a vertical axis: G / (2 pi r) (1 - exp(-r^2 / r_c^2)), counter-clockwise seen from above for G > 0
//             (Lamb and Oseen's vortex). Free of divergence; free of rotation outside the core
//   source    away from a vertical axis: the same function outwards, a sink for strength < 0. Free of rotation; free of
//             divergence outside the core
//
// The core of radius r_c keeps them finite: at the axis the velocity is 0. Its largest value, 0.64 strength / (2 pi r_c), is
// at 1.12 r_c; beyond 2.2 r_c the core adds less than 1 % to the ideal flow.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/wind_field.h"

namespace roseau::synthesis {

enum class FlowKind : std::uint8_t { uniform, vortex, source };

constexpr std::string_view to_string(FlowKind kind) {
  return kind == FlowKind::uniform ? "uniform" : kind == FlowKind::vortex ? "vortex" : "source";
}

struct FlowPrimitive {
  FlowKind kind = FlowKind::uniform;
  Vec3 velocity_mps;              // uniform
  Vec2 centre_in_world_m;         // vortex, source: at time 0
  double strength_m2ps = 0;       // vortex: circulation; source: volume per second and metre of height
  double core_radius_m = 1;       // vortex, source
  bool drifts_with_wind = false;  // carried by the mean wind, else it stays where it is
};

class FlowPrimitives final : public WindField {
 public:
  /// `drift_mps`: the mean wind that carries those that drift.
  FlowPrimitives(std::vector<FlowPrimitive> primitives, const Vec3& drift_mps);

  Vec3 velocity_mps(const Vec3& point_in_world, double time_s) const override;

 private:
  std::vector<FlowPrimitive> primitives_;
  Vec3 drift_mps_;
};

}  // namespace roseau::synthesis
