// Power spectra of natural wind at a fixed point: what the plant thesis (5.2.3) leaves open in its equation 5.3.
//
//   von Karman   isotropic turbulence, in the form wind engineering uses (ESDU 85020)
//   Kaimal       neutral air near the ground, in the form of IEC 61400-1: given sd and length scale of each component. With
//                length scales 5.5 z, 1.58 z and 0.4 z, and an sd of 2.18 u* along, 0.75 of it across and 0.57 of it up, it
//                is Kaimal et al. (1972) at the height z: their 105 n / (1 + 33 n)^(5/3) and 17 n / (1 + 9.5 n)^(5/3)
//                exactly, and within 1.6 dB their vertical 2.1 n / (1 + 5.3 n^(5/3)), which has another shape.
//
// All are one-sided, in (m/s)^2 per Hz; the integral over frequency is sd^2.
#pragma once

#include <cmath>
#include <cstdint>
#include <string_view>

namespace roseau::synthesis {

enum class TurbulenceSpectrum : std::uint8_t { von_karman, kaimal };

constexpr std::string_view to_string(TurbulenceSpectrum spectrum) {
  return spectrum == TurbulenceSpectrum::kaimal ? "kaimal" : "von_karman";
}

/// The component along the mean wind.
inline double von_karman_along(double frequency_hz, double mean_speed_mps, double sd_mps, double length_scale_m) {
  const double timescale_s = length_scale_m / mean_speed_mps;
  const double reduced = frequency_hz * timescale_s;
  return 4 * timescale_s * sd_mps * sd_mps / std::pow(1 + 70.8 * reduced * reduced, 5.0 / 6);
}

/// The components across the mean wind (horizontal or vertical) with their own, shorter, length scale.
inline double von_karman_across(double frequency_hz, double mean_speed_mps, double sd_mps, double length_scale_m) {
  const double timescale_s = length_scale_m / mean_speed_mps;
  const double reduced2 = std::pow(frequency_hz * timescale_s, 2);
  return 4 * timescale_s * sd_mps * sd_mps * (1 + 755.2 * reduced2) / std::pow(1 + 283.2 * reduced2, 11.0 / 6);
}

/// Any component.
inline double kaimal(double frequency_hz, double mean_speed_mps, double sd_mps, double length_scale_m) {
  const double timescale_s = length_scale_m / mean_speed_mps;
  return 4 * timescale_s * sd_mps * sd_mps / std::pow(1 + 6 * frequency_hz * timescale_s, 5.0 / 3);
}

}  // namespace roseau::synthesis
