// Time stepping of the modal oscillators (thesis 6.2.3).
#pragma once

#include <Eigen/Core>

#include "core/result.h"
#include "structure/mechanics/modal_model.h"

namespace roseau::structure {

/// Amplitudes and their rate, one per mode: u = sum of q_i phi_i.
struct ModalState {
  Eigen::VectorXd q;
  Eigen::VectorXd q_dot;

  static ModalState at_rest(std::size_t mode_count);
};

/// Kinetic plus elastic energy in joules.
double energy_j(const ModalModel& model, const ModalState& state);

/// Exact for modal forces that run straight from the step's beginning to its end; see oscillator_step.h. Stable for any step.
class ExactStepper {
 public:
  /// `extra_damping`: per mode, on top of the model's own, times the modal mass (WindProjection::damping); empty for none.
  ExactStepper(const ModalModel& model, double step_s, const Eigen::ArrayXd& extra_damping = {});

  /// `out` may be `from`. No allocation once `out` has its size.
  void advance(const ModalState& from, const Eigen::VectorXd& begin_force, const Eigen::VectorXd& end_force,
               ModalState& out) const;

  double step_s() const { return step_s_; }

 private:
  using Coefficients = Eigen::Array<double, Eigen::Dynamic, 4>;  // of position, velocity, force at the beginning and at the end

  double step_s_;
  Coefficients position_;
  Coefficients velocity_;
};

/// The thesis's own stepping, 6.19 to 6.21 (called explicit Euler there; it is the semi-implicit one): first order, and stable
/// only while w^2 dt^2 + 2 gamma dt < 4.
class SemiImplicitStepper {
 public:
  /// Error (invalid_argument): the step is too long for a mode; names the mode and the longest step that all modes bear.
  static Result<SemiImplicitStepper> make(const ModalModel& model, double step_s, const Eigen::ArrayXd& extra_damping = {});

  /// With the modal forces at the step's beginning.
  void advance(const ModalState& from, const Eigen::VectorXd& force, ModalState& out) const;

 private:
  SemiImplicitStepper(const ModalModel& model, double step_s, const Eigen::ArrayXd& damping_per_s);

  double step_s_;
  double modal_mass_;
  Eigen::ArrayXd stiffness_per_s2_;
  Eigen::ArrayXd damping_per_s_;
};

}  // namespace roseau::structure
