// Which damped oscillator is this, seen only by its sway under an unknown random force? Multitaper Whittle fit.
//
//   x'' + g x' + w0^2 x = f/m,   S_x(w) = A (w/wh)^-p / [(w0^2 - w^2)^2 + g^2 w^2] + B
//
// (VIDA thesis 4.1-4.2 for the oscillator; docs/estimation.md for the fit and for why half-power width and raw periodograms
// fail.) The spectrum of the force falls like w^-p: 5/3 in the wind's inertial range, 0 for a force without preference.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/result.h"
#include "estimation/multitaper.h"

namespace roseau::estimation {

/// A normal distribution of ln(damping ratio): holds a short record's damping in reason.
struct DampingPrior {
  double median_ratio = 0.05;
  double log_sd = 0.6;
};

struct IdentifyOptions {
  double min_frequency_hz = 0.3;  // where the resonance is looked for
  double max_frequency_hz = 4;
  double fit_low = 0.35;  // the fit uses the lines from fit_low to fit_high times the resonance found first
  double fit_high = 3;
  double force_slope = 5.0 / 3;  // p: 5/3 wind, 0 free or boats
  double force_slope_sd = 0.3;   // how far p may wander from it; 0 holds it
  std::optional<DampingPrior> damping_prior;
  double gate = 3;             // accepted when the resonance stands this far (power) above the white floor
  double resonance_gain = 12;  // and when a resonance explains the spectrum better than a power law and a floor by this
                               // much log-likelihood: drift and gusts on a stiff target (200 records each) reach 11
  std::vector<double> start_damping_ratios = {0.03, 0.10};  // the search begins from each, the best end counts
  double min_rate_hz = 12.5;  // decimated to the larger of this and rate_per_frequency times the resonance
  double rate_per_frequency = 8;
};

struct OscillatorFit {
  double natural_frequency_hz = 0;     // w0 / 2 pi
  double natural_frequency_sd_hz = 0;  // sqrt(g / 2D): the floor for a record of duration D under a white force
  double damping_ratio = 0;            // g / (2 w0)
  double damping_ratio_sd = 0;         // from sd(g)/g = sqrt(2 / (g D)), joined with the prior where there is one
  double gamma_per_s = 0;              // g
  double noise_sd = 0;                 // white noise of one sample before decimation, unit of the series
  double force_slope = 0;              // p
  double force_density = 0;            // one-sided, at the natural frequency, (unit/s^2)^2/Hz
  double peak_to_floor = 0;            // the gate's quantity
  double resonance_gain = 0;           // log-likelihood over the model without a resonance, each line counted once
  double duration_s = 0;
  bool accepted = false;
  Spectrum spectrum;  // what was fitted, at the decimated rate
  std::size_t decimation = 1;

  /// Fitted one-sided density at a frequency, floor included, before the tapers smear it: unit^2/Hz.
  double model_density(double frequency_hz) const;
  /// The floor's one-sided density, unit^2/Hz.
  double noise_density() const;
};

/// Series of one displacement component at a constant rate. Error (invalid_argument) when it is too short for the lowest
/// frequency asked for, holds a number that is not finite, or does not move at all. A fit that fails its gate is a value with
/// accepted == false.
Result<OscillatorFit> identify(std::span<const double> series, double sample_period_s, const IdentifyOptions& options = {});

}  // namespace roseau::estimation
