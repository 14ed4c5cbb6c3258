// Where an estimated force can be believed: VIDA thesis 5.4. White noise in the displacement, density 2 T s^2, appears in the
// force divided by the oscillator's squared response rho^2 (5.20): little at resonance, much above it. The force is trusted
// where its power stands above that by a stated ratio (5.21).
#pragma once

#include "core/sample.h"
#include "estimation/identify.h"

namespace roseau::estimation {

/// Power a person still takes for signal: the thesis suggests 10 to 30.
inline constexpr double kTrustRatio = 10;

/// rho^2: squared displacement per force per mass at a frequency, s^4.
double squared_response(double natural_frequency_hz, double damping_ratio, double frequency_hz);

/// One-sided density of the force that white displacement noise pretends: (unit/s^2)^2/Hz.
double white_noise_force_density(double noise_sd, double sample_period_s, double natural_frequency_hz, double damping_ratio,
                                 double frequency_hz);

struct TrustBand {
  double low_hz = 0;  // 0: down to the record's length
  double high_hz = 0;
  bool is_empty() const { return high_hz <= low_hz; }
};

/// The band round the resonance in which the 5-line mean of displacement power is at least `ratio` times the white floor:
/// empty where not even the resonance is. What is not white (drift of a tracker at the low end) is not seen here.
TrustBand trust_band(const OscillatorFit& fit, double ratio = kTrustRatio);

/// All of a fit that is worth showing, as the sample type of core.
ForceSpectrum force_spectrum(const OscillatorFit& fit, double ratio = kTrustRatio);

}  // namespace roseau::estimation
