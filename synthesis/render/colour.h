// Colours of the rendered scene.
#pragma once

namespace roseau::render {

/// 0..1 each: the share of full scale that a camera with gain 1 reads at light level 1. All light adds up linearly.
struct Colour {
  double red = 0;
  double green = 0;
  double blue = 0;
};

constexpr Colour mix(const Colour& a, const Colour& b, double share_of_b) {
  return {a.red + share_of_b * (b.red - a.red), a.green + share_of_b * (b.green - a.green),
          a.blue + share_of_b * (b.blue - a.blue)};
}

constexpr Colour scaled(const Colour& a, double factor) { return {a.red * factor, a.green * factor, a.blue * factor}; }

}  // namespace roseau::render
