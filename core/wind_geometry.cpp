#include "core/wind_geometry.h"

#include <cmath>
#include <numbers>
#include <string>

namespace roseau {

namespace {
constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;
constexpr std::string_view kSpar = "gill_spar";
constexpr std::string_view kAxis = "gill_axis";
constexpr std::string_view kEastNorth = "east_north";

// By how much the wind vector's angle is larger in spar axes. By 30 degrees: u_spar = u cos 30 - v sin 30,
// v_spar = u sin 30 + v cos 30. By -90: u_spar = v, v_spar = -u.
double angle_in_spar_deg(WindAxes axes) {
  switch (axes) {
    case WindAxes::gill_spar:
      return 0.0;
    case WindAxes::gill_axis:
      return 30.0;
    case WindAxes::east_north:
      return -90.0;
  }
  ROSEAU_CHECK(false);
  return 0.0;
}
}  // namespace

std::string_view to_string(WindAxes axes) {
  if (axes == WindAxes::east_north) return kEastNorth;
  return axes == WindAxes::gill_axis ? kAxis : kSpar;
}

Result<WindAxes> wind_axes_from_string(std::string_view name) {
  if (name == kSpar) return WindAxes::gill_spar;
  if (name == kAxis) return WindAxes::gill_axis;
  if (name == kEastNorth) return WindAxes::east_north;
  return Error{ErrorCode::invalid_argument, "axes '" + std::string(name) + "' are not known: gill_spar, gill_axis, east_north"};
}

double wrap_degrees(double angle_deg) {
  const double wrapped = std::fmod(angle_deg, 360.0);
  const double positive = wrapped < 0 ? wrapped + 360.0 : wrapped;
  return positive < 360.0 ? positive : 0.0;  // a tiny negative angle rounds up to 360
}

double wind_direction_deg(double u, double v, double north_offset_deg, WindAxes axes) {
  const double angle_deg = std::atan2(v, u) * kDegreesPerRadian + angle_in_spar_deg(axes);
  return wrap_degrees(180.0 - angle_deg + north_offset_deg);
}

Vec2 wind_components_mps(double speed_mps, double direction_deg, double north_offset_deg, WindAxes axes) {
  const double angle_deg = 180.0 + north_offset_deg - direction_deg - angle_in_spar_deg(axes);
  const double angle_rad = angle_deg / kDegreesPerRadian;
  return {speed_mps * std::cos(angle_rad), speed_mps * std::sin(angle_rad)};
}

}  // namespace roseau
