// The damped oscillator x'' + gamma x' + w^2 x = a(t) over one step, exact for a force that runs straight from the step's
// beginning to its end.
#pragma once

namespace roseau::structure {

/// x and x' at the end of the step are linear in x, x' at its beginning and in the force per mass at both ends.
struct ExactOscillatorStep {
  struct Row {
    double position = 0;
    double velocity = 0;
    double begin_force = 0;
    double end_force = 0;
  };
  Row position;  // x at the end = position.position * x + position.velocity * x' + ...
  Row velocity;
};

/// Any w^2 >= 0 and gamma >= 0 (under-, critically and overdamped; none of either), any step >= 0. No cancellation: wherever
/// w step and gamma step lie, each coefficient is good to 2e-13 of its own size (where a cosine crosses zero: to 1e-15).
ExactOscillatorStep exact_oscillator_step(double stiffness_per_s2, double damping_per_s, double step_s);

}  // namespace roseau::structure
