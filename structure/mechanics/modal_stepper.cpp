#include "structure/mechanics/modal_stepper.h"

#include <fmt/format.h>

#include <cmath>

#include "structure/mechanics/oscillator_step.h"

namespace roseau::structure {
namespace {

Eigen::ArrayXd total_damping(const ModalModel& model, const Eigen::ArrayXd& extra_damping) {
  if (extra_damping.size() == 0) return model.damping_coefficient_per_s();
  ROSEAU_CHECK(extra_damping.size() == model.damping_coefficient_per_s().size());
  return model.damping_coefficient_per_s() + extra_damping / model.modal_mass();
}

}  // namespace

ModalState ModalState::at_rest(std::size_t mode_count) {
  const auto size = static_cast<Eigen::Index>(mode_count);
  return {Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size)};
}

double energy_j(const ModalModel& model, const ModalState& state) {
  return 0.5 * model.modal_mass() * (state.q_dot.squaredNorm() + (model.stiffness_per_s2() * state.q.array().square()).sum());
}

ExactStepper::ExactStepper(const ModalModel& model, double step_s, const Eigen::ArrayXd& extra_damping) : step_s_(step_s) {
  const Eigen::ArrayXd damping = total_damping(model, extra_damping);
  position_.resize(damping.size(), 4);
  velocity_.resize(damping.size(), 4);
  for (Eigen::Index i = 0; i < damping.size(); ++i) {
    const ExactOscillatorStep step = exact_oscillator_step(model.stiffness_per_s2()[i], damping[i], step_s);
    const auto row = [m = model.modal_mass()](const ExactOscillatorStep::Row& r) {
      return Eigen::Array<double, 1, 4>(r.position, r.velocity, r.begin_force / m, r.end_force / m);
    };
    position_.row(i) = row(step.position);
    velocity_.row(i) = row(step.velocity);
  }
}

void ExactStepper::advance(const ModalState& from, const Eigen::VectorXd& begin_force, const Eigen::VectorXd& end_force,
                           ModalState& out) const {
  if (&out != &from) {
    out.q.resize(from.q.size());
    out.q_dot.resize(from.q.size());
  }
  for (Eigen::Index i = 0; i < from.q.size(); ++i) {
    const double q = from.q[i];
    const double q_dot = from.q_dot[i];
    const double begin = begin_force[i];
    const double end = end_force[i];
    out.q[i] = position_(i, 0) * q + position_(i, 1) * q_dot + (position_(i, 2) * begin + position_(i, 3) * end);
    out.q_dot[i] = velocity_(i, 0) * q + velocity_(i, 1) * q_dot + (velocity_(i, 2) * begin + velocity_(i, 3) * end);
  }
}

Result<SemiImplicitStepper> SemiImplicitStepper::make(const ModalModel& model, double step_s,
                                                      const Eigen::ArrayXd& extra_damping) {
  const Eigen::ArrayXd damping = total_damping(model, extra_damping);
  const Eigen::ArrayXd& stiffness = model.stiffness_per_s2();
  Eigen::Index worst = 0;
  // The step at which w^2 dt^2 + 2 gamma dt reaches 4, without cancellation for gamma >> w.
  const Eigen::ArrayXd limit_s = 4 / (damping + (damping.square() + 4 * stiffness).sqrt());
  const double longest_s = limit_s.minCoeff(&worst);
  if (!(step_s > 0) || step_s >= longest_s) {
    return Error{
        ErrorCode::invalid_argument,
        fmt::format("semi-implicit stepping with {} s is unstable: mode {} ({:.3g} Hz) needs less than {:.3g} s; take a "
                    "shorter step, fewer modes, or exact stepping",
                    step_s, worst, model.natural_frequency_hz(static_cast<std::size_t>(worst)), longest_s)};
  }
  return SemiImplicitStepper(model, step_s, damping);
}

SemiImplicitStepper::SemiImplicitStepper(const ModalModel& model, double step_s, const Eigen::ArrayXd& damping_per_s)
    : step_s_(step_s),
      modal_mass_(model.modal_mass()),
      stiffness_per_s2_(model.stiffness_per_s2()),
      damping_per_s_(damping_per_s) {}

void SemiImplicitStepper::advance(const ModalState& from, const Eigen::VectorXd& force, ModalState& out) const {
  out.q_dot = from.q_dot.array() + step_s_ * (force.array() / modal_mass_ - damping_per_s_ * from.q_dot.array() -
                                              stiffness_per_s2_ * from.q.array());
  out.q = from.q + step_s_ * out.q_dot;
}

}  // namespace roseau::structure
