#include "core/wind_geometry.h"

#include <cmath>
#include <numbers>
#include <string>

namespace roseau {

namespace {
constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;
constexpr std::string_view kSpar = "gill_spar";
constexpr std::string_view kAxis = "gill_axis";

// u_spar = u cos 30 - v sin 30, v_spar = u sin 30 + v cos 30: the wind vector's angle grows by this.
double angle_in_spar_deg(WindAxes axes) { return axes == WindAxes::gill_axis ? 30.0 : 0.0; }
}  // namespace

std::string_view to_string(WindAxes axes) { return axes == WindAxes::gill_axis ? kAxis : kSpar; }

Result<WindAxes> wind_axes_from_string(std::string_view name) {
  if (name == kSpar) return WindAxes::gill_spar;
  if (name == kAxis) return WindAxes::gill_axis;
  return Error{ErrorCode::invalid_argument, "axes '" + std::string(name) + "' are not known: gill_spar, gill_axis"};
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
