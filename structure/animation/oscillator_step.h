// One step of a damped oscillator  q'' + gamma q' + (2 pi f)^2 q = f(t),  exact when the force is linear in time over the step
// (and so also when it is constant): no stability limit, no damping or period of its own, whatever the step.
#pragma once

namespace roseau::structure {

/// The state after the step from the state before it and the force at both ends:
///     q1 = q0 + q_less_one_from_q q0 + q_from_rate r0 + q_from_start_force f0 + q_from_end_force f1, the rate alike.
/// The unit part is split off because it rounds everything else away in single precision where steps are short.
struct OscillatorStep {
  double q_less_one_from_q = 0;
  double q_from_rate = 0;
  double q_from_start_force = 0;
  double q_from_end_force = 0;
  double rate_from_q = 0;
  double rate_less_one_from_rate = 0;
  double rate_from_start_force = 0;
  double rate_from_end_force = 0;
};

/// Under-damped, critical and over-damped alike. A step of zero changes nothing.
OscillatorStep oscillator_step(double natural_frequency_hz, double damping_coefficient_per_s, double step_s);

}  // namespace roseau::structure
