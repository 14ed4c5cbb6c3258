// How alike the turbulence is at two points across the wind: Davenport's exponential, with a finite value at frequency 0
//
//   coherence(f) = exp(-sqrt(f^2 + (0.1 U / L)^2) s),    s = sqrt((C_y dy)^2 + (C_z dz)^2) / U
//
// (root coherence: the cross spectrum divided by the root of the two power spectra).
#pragma once

#include <cmath>

namespace roseau::synthesis {

struct DavenportCoherence {
  double mean_speed_mps = 1;
  double lateral_decay = 10;   // C_y
  double vertical_decay = 10;  // C_z
  double length_scale_m = 30;  // L, of the component in question

  /// s above, in seconds.
  double separation_s(double lateral_m, double vertical_m) const {
    return std::hypot(lateral_decay * lateral_m, vertical_decay * vertical_m) / mean_speed_mps;
  }
  /// The root above, in Hz.
  double rate_hz(double frequency_hz) const { return std::hypot(frequency_hz, 0.1 * mean_speed_mps / length_scale_m); }

  double at(double frequency_hz, double lateral_m, double vertical_m) const {
    return std::exp(-rate_hz(frequency_hz) * separation_s(lateral_m, vertical_m));
  }
};

}  // namespace roseau::synthesis
