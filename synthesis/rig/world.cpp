#include "synthesis/rig/world.h"

#include <array>
#include <cmath>
#include <numbers>

#include "core/wind_geometry.h"

namespace roseau::synthesis {

namespace {
std::shared_ptr<const TurbulentWind> make_wind(const Scene& scene, const Vec3& drag_point) {
  return std::make_shared<TurbulentWind>(scene.wind, scene.seed, std::array{drag_point, scene.sonic.position_in_world_m});
}
}  // namespace

World::World(const Scene& its_scene)
    : scene(its_scene), drag_point(target_centre_in_world(its_scene)), wind(make_wind(scene, drag_point)) {}

BranchMotion World::branch_motion() const {
  const BranchScene& branch = scene.branch;
  return {{.natural_frequency_hz = branch.natural_frequency_hz,
           .damping_ratio = branch.damping_ratio,
           .drag_exponent = branch.drag_exponent,
           .mean_deflection_m = branch.mean_deflection_m,
           .axis_in_world = {1, 0, 0},
           .drag_point_in_world = drag_point},
          scene.wind.mean_speed_mps,
          wind};
}

WindSample World::wind_in_sonic_axes(const Vec3& point_in_world, double time_s) const {
  const Vec3 air = wind->velocity_mps(point_in_world, time_s);
  const double from_deg = wrap_degrees(std::atan2(-air.x, -air.y) * 180 / std::numbers::pi);
  const Vec2 horizontal = wind_components_mps(std::hypot(air.x, air.y), from_deg, scene.sonic.north_offset_deg);
  WindSample sample;
  sample.u_mps = horizontal.x;
  sample.v_mps = horizontal.y;
  sample.w_mps = air.z;
  sample.sonic_temperature_celsius = air_temperature_celsius(scene.sonic, air.z);
  sample.speed_of_sound_mps = synthesis::speed_of_sound_mps(sample.sonic_temperature_celsius);
  return sample;
}

}  // namespace roseau::synthesis
