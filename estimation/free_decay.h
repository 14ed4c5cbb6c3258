// Natural frequency and damping of a target that was pulled and let go: one damped sinusoid fitted to its free decay.
//
//   y(t) = exp(-zeta w0 t) (a cos wd t + b sin wd t) + c + d t,   wd = w0 sqrt(1 - zeta^2)
//
// Amplitudes, offset and drift are linear and solved exactly for every (w0, zeta) tried (variable projection, Golub and Pereyra
// 1973); only (w0, zeta) are searched.
#pragma once

#include <cstddef>
#include <span>

#include "core/result.h"

namespace roseau::estimation {

struct FrequencyBand {
  double min_hz = 0.1;
  double max_hz = 2;
};

struct FreeDecay {
  double natural_frequency_hz = 0;  // undamped, w0 / 2 pi
  double natural_frequency_sd_hz = 0;
  double damping_ratio = 0;
  double damping_ratio_sd = 0;
  double amplitude = 0;         // of the sinusoid at the start of the decay, unit of the series
  double spectral_peak_hz = 0;  // highest line of the plain spectrum in the band, interpolated: an independent check
  double resolution_hz = 0;     // 1 / length of the record
  double start_s = 0;           // where the decay begins in the series
  double duration_s = 0;        // of the decay fitted
  double explained = 0;         // 1 - residual variance / variance of the detrended decay
};

/// Series of one component at a constant rate; it may begin before the release. The resonance looked for lies in `band`.
///
/// Standard deviations are those of least squares with COLOURED residuals: cov = (J'J)^-1 J'RJ (J'J)^-1, where R is the
/// stationary covariance whose spectrum is the multitaper spectrum of the residuals. White-noise formulae would be far too
/// small where a second mode or wind is left over. Joined to them is the spread of the fits that begin up to two periods later
/// and describe the rest as well: frequency and damping of a real tree change with the amplitude of its sway.
///
/// Error (invalid_argument): the band is empty, does not fit below half the rate, or holds less than two periods of the record;
/// values that are not finite; a series that does not move; nothing in the band that decays.
Result<FreeDecay> fit_free_decay(std::span<const double> series, double rate_hz, const FrequencyBand& band);

}  // namespace roseau::estimation
