#include "structure/mechanics/sway_simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace roseau::structure {
namespace {

Result<void> check_pull(const RopePull& pull, std::size_t node_count) {
  if (pull.node >= node_count) {
    return Error{ErrorCode::invalid_argument, fmt::format("a rope on node {}: the tree has {} nodes", pull.node, node_count)};
  }
  if (!(pull.ramp_s >= 0 && pull.release_s >= pull.start_s + pull.ramp_s)) {
    return Error{ErrorCode::invalid_argument,
                 fmt::format("a rope that is pulled from {} s for {} s and released at {} s: the release must come last",
                             pull.start_s, pull.ramp_s, pull.release_s)};
  }
  return {};
}

/// Cubic between two states.
ModalState between(const ModalState& begin, const ModalState& end, double step_s, double share) {
  const double x = share;
  const double toward = x * x * (3 - 2 * x);
  ModalState state;
  state.q = (1 - toward) * begin.q + toward * end.q + step_s * x * (1 - x) * ((1 - x) * begin.q_dot - x * end.q_dot);
  state.q_dot =
      6 * x * (1 - x) / step_s * (end.q - begin.q) + (1 - x) * (1 - 3 * x) * begin.q_dot + x * (3 * x - 2) * end.q_dot;
  return state;
}

}  // namespace

double SwaySimulation::Rope::share_before(double time_s) const {
  if (time_s <= pull.start_s || time_s > pull.release_s) return 0;
  return time_s <= pull.start_s + pull.ramp_s ? (time_s - pull.start_s) / pull.ramp_s : 1;
}

double SwaySimulation::Rope::share_after(double time_s) const {
  if (time_s < pull.start_s || time_s >= pull.release_s) return 0;
  return time_s < pull.start_s + pull.ramp_s ? (time_s - pull.start_s) / pull.ramp_s : 1;
}

Result<SwaySimulation> SwaySimulation::make(ModalModel model, DragLoad load, const WindField& wind,
                                            const SwayOptions& options) {
  ROSEAU_CHECK(load.mode_count() == model.mode_count());
  if (!(std::isfinite(options.step_s) && options.step_s > 0)) {
    return Error{ErrorCode::invalid_argument, fmt::format("a simulation cannot have steps of {} s", options.step_s)};
  }
  for (const RopePull& pull : options.pulls) {
    if (auto checked = check_pull(pull, model.node_count()); !checked) return checked.error();
  }
  SwaySimulation simulation(std::move(model), std::move(load), wind, options);
  if (auto made = simulation.make_stepper(); !made) return made.error();
  return simulation;
}

SwaySimulation::SwaySimulation(ModalModel model, DragLoad load, const WindField& wind, SwayOptions options)
    : model_(std::move(model)), load_(std::move(load)), wind_(&wind), options_(std::move(options)), projection_(load_) {
  for (const RopePull& pull : options_.pulls) ropes_.push_back({pull, model_.modal_force_at(pull.node, pull.force_n)});
  state_ = ModalState::at_rest(model_.mode_count());
  if (options_.load == SwayOptions::Load::full_integration) air_mps_.resize(load_.points_in_world().size());
  sample_wind(options_.start_s);
  drag(state_.q_dot, force_);
  if (options_.start == SwayOptions::Start::in_equilibrium) state_.q = model_.static_amplitudes(force_ + rope_force());
  begin_state_ = state_;
  begin_force_ = end_force_ = force_;
}

Result<void> SwaySimulation::make_stepper() {
  Eigen::ArrayXd extra_damping;
  if (options_.load == SwayOptions::Load::projection) extra_damping = projection_.damping(options_.mean_wind_mps);
  if (options_.stepping == SwayOptions::Stepping::exact) {
    stepper_ = ExactStepper(model_, options_.step_s, extra_damping);
    return {};
  }
  auto stepper = SemiImplicitStepper::make(model_, options_.step_s, extra_damping);
  if (!stepper) return stepper.error();
  stepper_ = std::move(*stepper);
  return {};
}

Result<void> SwaySimulation::set_parameters(const ModalParameters& parameters) {
  const ModalParameters before = model_.parameters();
  if (auto set = model_.set_parameters(parameters); !set) return set;
  auto made = make_stepper();
  if (!made) ROSEAU_CHECK(model_.set_parameters(before).has_value());
  // The last step was made with the old parameters: it cannot be evaluated any more but at its end.
  begin_state_ = state_;
  begin_force_ = end_force_ = force_;
  return made;
}

void SwaySimulation::sample_wind(double time_s) {
  if (options_.load == SwayOptions::Load::projection) {
    centre_air_mps_ = wind_->velocity_mps(projection_.centre_in_world(), time_s);
  } else {
    wind_->velocities_mps(load_.points_in_world(), time_s, air_mps_);
  }
}

void SwaySimulation::drag(const Eigen::VectorXd& q_dot, Eigen::VectorXd& force) {
  if (options_.load == SwayOptions::Load::projection) {
    projection_.modal_force(centre_air_mps_, force);
  } else {
    load_.modal_force(air_mps_, q_dot, force);
  }
}

void SwaySimulation::advance() {
  if (const auto* stepper = std::get_if<SemiImplicitStepper>(&stepper_)) {
    advance_semi_implicitly(*stepper);
  } else {
    advance_exactly();
  }
}

void SwaySimulation::advance_exactly() {
  const double from_s = time_s();
  const double to_s = time_at(step_count_ + 1);
  begin_state_ = state_;
  begin_force_ = force_;
  propagate(from_s, to_s, begin_force_, begin_force_, state_);
  sample_wind(to_s);
  drag(state_.q_dot, end_force_);
  state_ = begin_state_;
  propagate(from_s, to_s, begin_force_, end_force_, state_);
  drag(state_.q_dot, force_);
  ++step_count_;
}

void SwaySimulation::advance_semi_implicitly(const SemiImplicitStepper& stepper) {
  begin_state_ = state_;
  begin_force_ = force_;
  add_ropes(time_s(), &Rope::share_after, force_);
  stepper.advance(begin_state_, force_, state_);
  ++step_count_;
  sample_wind(time_s());
  drag(state_.q_dot, force_);
  end_force_ = force_;
}

void SwaySimulation::resume(const Checkpoint& checkpoint) {
  step_count_ = checkpoint.step_count;
  state_ = checkpoint.state;
  force_ = checkpoint.wind_force;
  // There is no last step to evaluate: state_at() knows its end only.
  begin_state_ = state_;
  begin_force_ = end_force_ = force_;
}

Eigen::VectorXd SwaySimulation::rope_force() const {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(model_.mode_count()));
  add_ropes(time_s(), &Rope::share_after, force);
  return force;
}

void SwaySimulation::add_ropes(double time_s, double (Rope::*share)(double) const, Eigen::VectorXd& force) const {
  for (const Rope& rope : ropes_) force += (rope.*share)(time_s)*rope.force;
}

void SwaySimulation::find_breaks(double from_s, double to_s, std::vector<double>& breaks) const {
  for (const Rope& rope : ropes_) {
    for (const double time_s : {rope.pull.start_s, rope.pull.start_s + rope.pull.ramp_s, rope.pull.release_s}) {
      if (time_s > from_s && time_s < to_s) breaks.push_back(time_s);
    }
  }
  std::ranges::sort(breaks);
}

void SwaySimulation::propagate(double from_s, double to_s, const Eigen::VectorXd& begin_force, const Eigen::VectorXd& end_force,
                               ModalState& state) const {
  const auto& whole = std::get<ExactStepper>(stepper_);
  const bool is_whole = to_s - from_s == time_at(step_count_ + 1) - time_at(step_count_) && from_s == time_s();
  if (ropes_.empty() && is_whole) return whole.advance(state, begin_force, end_force, state);

  // The ropes' forces are straight between the breaks only.
  std::vector<double> ends;
  find_breaks(from_s, to_s, ends);
  ends.push_back(to_s);
  Eigen::ArrayXd extra_damping;
  if (options_.load == SwayOptions::Load::projection) extra_damping = projection_.damping(options_.mean_wind_mps);
  double part_from_s = from_s;
  for (const double part_to_s : ends) {
    const auto wind_force = [&](double time_s) -> Eigen::VectorXd {
      return begin_force + (time_s - from_s) / (to_s - from_s) * (end_force - begin_force);
    };
    Eigen::VectorXd begin = wind_force(part_from_s);
    Eigen::VectorXd end = wind_force(part_to_s);
    add_ropes(part_from_s, &Rope::share_after, begin);
    add_ropes(part_to_s, &Rope::share_before, end);
    if (is_whole && ends.size() == 1) {
      whole.advance(state, begin, end, state);
    } else {
      ExactStepper(model_, part_to_s - part_from_s, extra_damping).advance(state, begin, end, state);
    }
    part_from_s = part_to_s;
  }
}

ModalState SwaySimulation::state_at(double time_s) const {
  const double to_s = this->time_s();
  const double from_s = step_count_ == 0 ? to_s : time_at(step_count_ - 1);
  const double share = to_s > from_s ? std::clamp((time_s - from_s) / (to_s - from_s), 0.0, 1.0) : 1;
  if (share == 1) return state_;
  if (std::holds_alternative<SemiImplicitStepper>(stepper_)) return between(begin_state_, state_, options_.step_s, share);
  ModalState state = begin_state_;
  if (share > 0) propagate(from_s, time_s, begin_force_, begin_force_ + share * (end_force_ - begin_force_), state);
  return state;
}

}  // namespace roseau::structure
