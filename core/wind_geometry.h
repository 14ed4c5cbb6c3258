// Where the wind comes from. Pure.
//
// An anemometer measures in its own axes; nobody rotates what it sent. The direction is worked out from the axes convention
// and the north offset that travel with the stream (metadata "axes", "north_offset_deg"):
//
//   gill_spar   right-handed; u > 0: wind from the south, v > 0: from the east, w > 0: upwards, where "north" is the
//               instrument's north spar or N mark. The offset is the azimuth of that mark, degrees clockwise from north.
//               direction = 180 - atan2(v, u) + north offset    (checked against EddyPro on the Hohes Holz record)
//   gill_axis   the same turned by 30 degrees: u runs along the first transducer axis (Gill's AXIS setting)
//   east_north  u > 0: from the west, v > 0: from the south, w > 0: upwards, where "north" is the instrument's own mark
//               (meteorologists' components; Anemoment's TriSonica). The same turned by 90 degrees.
#pragma once

#include <cstdint>
#include <string_view>

#include "core/geometry.h"
#include "core/result.h"

namespace roseau {

enum class WindAxes : std::uint8_t { gill_spar, gill_axis, east_north };
std::string_view to_string(WindAxes axes);
Result<WindAxes> wind_axes_from_string(std::string_view name);

/// The angle brought into 0 <= angle < 360.
double wrap_degrees(double angle_deg);

/// Meteorological direction: where the wind comes from, degrees clockwise from north, 0 <= direction < 360. u and v in any
/// one unit; NaN gives NaN.
double wind_direction_deg(double u, double v, double north_offset_deg, WindAxes axes = WindAxes::gill_spar);

/// u (x) and v (y) that an instrument with this mounting shows for a horizontal wind from `direction_deg`.
Vec2 wind_components_mps(double speed_mps, double direction_deg, double north_offset_deg, WindAxes axes = WindAxes::gill_spar);

}  // namespace roseau
