#include "synthesis/oscillator/damped_oscillator.h"

#include <cmath>
#include <numbers>

#include "core/check.h"

namespace roseau::synthesis {

DampedOscillator::DampedOscillator(double natural_frequency_hz, double damping_ratio)
    : w0_(2 * std::numbers::pi * natural_frequency_hz),
      decay_per_s_(damping_ratio * w0_),
      wd_(w0_ * std::sqrt(1 - damping_ratio * damping_ratio)) {
  ROSEAU_CHECK(natural_frequency_hz > 0 && damping_ratio >= 0 && damping_ratio < 1);
}

// Under f = f0 + s t a particular solution is (f0 + s t) / w0^2 - gamma s / w0^4; what is left swings freely.
OscillatorState DampedOscillator::step(const OscillatorState& state, double force_begin, double force_end,
                                       double duration_s) const {
  if (duration_s <= 0) return state;
  const double w2 = w0_ * w0_;
  const double slope = (force_end - force_begin) / duration_s;
  const double lag = 2 * decay_per_s_ * slope / (w2 * w2);
  const double position = state.position - (force_begin / w2 - lag);
  const double velocity = state.velocity_per_s - slope / w2;

  const double envelope = std::exp(-decay_per_s_ * duration_s);
  const double c = std::cos(wd_ * duration_s);
  const double s = std::sin(wd_ * duration_s) / wd_;
  return {envelope * (position * (c + decay_per_s_ * s) + velocity * s) + force_end / w2 - lag,
          envelope * (velocity * (c - decay_per_s_ * s) - position * w2 * s) + slope / w2};
}

}  // namespace roseau::synthesis
