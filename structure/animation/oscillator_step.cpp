#include "structure/animation/oscillator_step.h"

#include <Eigen/Dense>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

namespace roseau::structure {

OscillatorStep oscillator_step(double natural_frequency_hz, double damping_coefficient_per_s, double step_s) {
  const double omega = 2 * std::numbers::pi * natural_frequency_hz;
  // The state is joined by the force and its slope over the step, which is counted in steps: the exponential of the joint
  // system then holds every coefficient, without a case for each kind of damping.
  Eigen::Matrix4d joint = Eigen::Matrix4d::Zero();
  joint(0, 1) = step_s;
  joint(1, 0) = -omega * omega * step_s;
  joint(1, 1) = -damping_coefficient_per_s * step_s;
  joint(1, 2) = step_s;
  joint(2, 3) = 1;
  const Eigen::Matrix4d step = joint.exp();
  return {.q_less_one_from_q = step(0, 0) - 1,
          .q_from_rate = step(0, 1),
          .q_from_start_force = step(0, 2) - step(0, 3),
          .q_from_end_force = step(0, 3),
          .rate_from_q = step(1, 0),
          .rate_less_one_from_rate = step(1, 1) - 1,
          .rate_from_start_force = step(1, 2) - step(1, 3),
          .rate_from_end_force = step(1, 3)};
}

}  // namespace roseau::structure
