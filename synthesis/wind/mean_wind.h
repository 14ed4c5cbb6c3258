// The mean wind: its direction, and MeanProfile: how it grows with height.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/geometry.h"

namespace roseau::synthesis {

enum class ProfileShape : std::uint8_t { uniform, power, logarithmic };

constexpr std::string_view to_string(ProfileShape shape) {
  return shape == ProfileShape::uniform ? "uniform" : shape == ProfileShape::power ? "power" : "logarithmic";
}

struct MeanProfileOptions {
  ProfileShape shape = ProfileShape::power;
  double reference_height_m = 2.6;   // where the mean is the stated one
  double exponent = 0;               // power: mean ~ (height / reference)^exponent
  double roughness_length_m = 0.03;  // logarithmic: mean ~ ln((height - displacement) / roughness)
  double displacement_height_m = 0;  // logarithmic: the ground as the wind above a crop or a wood sees it
};

/// Unit vector towards which a wind from this direction (clockwise from north) blows.
Vec3 towards_from_direction(double direction_from_deg);

class MeanProfile {
 public:
  explicit MeanProfile(const MeanProfileOptions& options);

  /// Mean at a height / mean at the reference height. From a table: within 2e-6 of the formula. Power: constant below
  /// 0.1 m, where it has no meaning. Logarithmic: 0 up to displacement + roughness. Constant above 1000 m.
  double ratio(double height_m) const;

 private:
  double formula(double height_m) const;  // height above the displacement

  MeanProfileOptions options_;
  double lowest_m_ = 0;
  std::uint64_t first_key_ = 0;
  std::vector<double> table_;
};

}  // namespace roseau::synthesis
