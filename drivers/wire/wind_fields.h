// What the records of Gill's 2-D and 3-D anemometers share beyond their fields: directions, plausibility, delimiters.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry.h"
#include "core/sample.h"

namespace roseau::wire {

/// Nothing on earth's surface that these instruments survive is faster.
inline constexpr double kFastestWind_mps = 100;

/// NaN (not measured) is plausible.
inline bool is_plausible_wind(double wind_mps) { return std::isnan(wind_mps) || std::abs(wind_mps) <= kFastestWind_mps; }

/// u (x) and v (y) in m/s from a record's two fields: components if they are signed, else direction and speed. NaN where
/// the instrument left them empty or full of nines; 0 where only the direction is empty (calm, below the instrument's
/// threshold). Nothing when they make no sense.
std::optional<Vec2> parse_horizontal_wind(std::string_view first, std::string_view second, double mps_per_unit);

bool is_signed(std::string_view field);

struct Polar {
  double speed = 0;
  double direction_deg = 0;  // from, 0 <= direction < 360
};
Polar polar_from_components(double u, double v);

/// The sample's values taken away: the instrument says that they mean nothing.
WindSample without_values(std::uint16_t device_status);

/// STX body ETX checksum, and the terminator.
std::string delimited(std::string_view body, std::string_view terminator);

std::vector<std::byte> to_bytes(std::string_view text);

}  // namespace roseau::wire
