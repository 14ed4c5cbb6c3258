// Power spectra of natural wind at a fixed point: von Karman's, in the form wind engineering uses (ESDU 85020). This is the
// stochastic wind of the plant thesis, 5.2.3, with the exponent that its equation 5.3 leaves open.
#pragma once

#include <cmath>

namespace roseau::synthesis {

/// Spectrum of the component along the mean wind: one-sided, (m/s)^2 per Hz; its integral over frequency is sd^2.
inline double von_karman_along(double frequency_hz, double mean_speed_mps, double sd_mps, double length_scale_m) {
  const double timescale_s = length_scale_m / mean_speed_mps;
  const double reduced = frequency_hz * timescale_s;
  return 4 * timescale_s * sd_mps * sd_mps / std::pow(1 + 70.8 * reduced * reduced, 5.0 / 6);
}

/// The same for the components across the mean wind (horizontal or vertical) with their own, shorter, length scale.
inline double von_karman_across(double frequency_hz, double mean_speed_mps, double sd_mps, double length_scale_m) {
  const double timescale_s = length_scale_m / mean_speed_mps;
  const double reduced2 = std::pow(frequency_hz * timescale_s, 2);
  return 4 * timescale_s * sd_mps * sd_mps * (1 + 755.2 * reduced2) / std::pow(1 + 283.2 * reduced2, 11.0 / 6);
}

}  // namespace roseau::synthesis
