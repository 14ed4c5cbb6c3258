// One damped oscillator, x'' + gamma x' + w0^2 x = f(t), stepped exactly for a force that is linear between two times.
// gamma = 2 zeta w0 (VIDA thesis 4.1).
#pragma once

namespace roseau::synthesis {

struct OscillatorState {
  double position = 0;
  double velocity_per_s = 0;
};

class DampedOscillator {
 public:
  /// Damping ratio in [0, 1): it does oscillate.
  DampedOscillator(double natural_frequency_hz, double damping_ratio);

  /// The state `duration_s` later, while the force per mass goes linearly from `force_begin` to `force_end`.
  OscillatorState step(const OscillatorState& state, double force_begin, double force_end, double duration_s) const;

  double angular_frequency_rad_s() const { return w0_; }
  double damping_coefficient_per_s() const { return 2 * decay_per_s_; }

 private:
  double w0_;           // undamped
  double decay_per_s_;  // zeta w0
  double wd_;           // damped angular frequency
};

}  // namespace roseau::synthesis
