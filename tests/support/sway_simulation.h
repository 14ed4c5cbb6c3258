// Simulated sway for tests and benchmarks: turbulent wind, one damped oscillator, camera noise. Small on purpose; the simulated
// field rig lives in synthesis/. Every number follows from the seed on every machine with the same libm: std::mt19937_64 is
// specified to the bit, std::normal_distribution is not, so normal deviates are made here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

namespace roseau::testing {

class GaussianSource {
 public:
  explicit GaussianSource(std::uint64_t seed) : engine_(seed) {}
  /// In (0, 1).
  double uniform();
  /// Mean 0, variance 1 (Box and Muller, one of the pair).
  double normal();

 private:
  std::mt19937_64 engine_;
};

struct WindOptions {
  double mean_mps = 4;
  double turbulence_intensity = 0.3;
  double length_scale_m = 30;
};

/// Wind along one line with von Karman's longitudinal spectrum, scaled so that this record's own standard deviation is
/// intensity * mean.
std::vector<double> von_karman_wind(GaussianSource& random, std::size_t samples, double sample_period_s,
                                    const WindOptions& options = {});

/// x'' + gamma x' + w0^2 x = force, exact for a force that is straight between samples; starts at rest under force[0].
std::vector<double> oscillator_response(std::span<const double> force, double sample_period_s, double w0_rad_s,
                                        double gamma_per_s);

/// Zero-phase filter of power 1 / (1 + (f/cut)^16)^2 by FFT over the whole series; keeps the mean.
std::vector<double> zero_phase_low_pass(std::span<const double> series, double sample_period_s, double cut_hz);

double correlation(std::span<const double> a, std::span<const double> b);
double rms_difference(std::span<const double> a, std::span<const double> b);

/// Sway of a target in a camera: wind V, force k V|V|, displacement in px with noise, at the frame rate.
struct SwayOptions {
  double natural_frequency_hz = 1;
  double damping_ratio = 0.05;
  double rate_hz = 30;
  double noise_px = 0.3;
  double duration_s = 120;
  double mean_deflection_px = 10;  // under the mean wind
  double rest_offset_px = 0;
  double drag_exponent = 2;  // force = k |V|^n sign V
  WindOptions wind;
};

struct Sway {
  std::vector<double> wind_mps;
  std::vector<double> displacement_px;
  std::vector<double> force;  // px / s^2, without the rest offset
  double force_per_drag = 0;  // k: px / s^2 per (m/s)^n
  double sample_period_s = 0;
};

Sway simulate_sway(std::uint64_t seed, const SwayOptions& options);

/// The linear congruential generator behind the portable test vector: s = (1103515245 s + 12345) mod 2^31.
class PortableRandom {
 public:
  explicit PortableRandom(std::uint32_t seed) : state_(seed) {}
  double uniform();

 private:
  std::uint64_t state_;
};

}  // namespace roseau::testing
