// SwaySimulation: a tree in the wind, step by step (thesis 6.2.3 with 6.3), and pulled with a rope (2.3.3).
//
// Exact stepping needs the modal force at the step's end, which depends, through the relative velocity, on the motion there. It
// is predicted with the force held, the drag evaluated, the step done again with the force running straight between both ends,
// and the drag evaluated again at the corrected motion. The error falls with the square of the step. Aerodynamic damping alone
// limits the step: it must stay below 2 over the greatest damping coefficient that the wind gives a mode (30 per second for
// bare leaves in a storm: 0.06 s); the modes' own stiffness and damping do not.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <variant>
#include <vector>

#include "core/result.h"
#include "core/wind_field.h"
#include "structure/mechanics/drag_load.h"
#include "structure/mechanics/modal_model.h"
#include "structure/mechanics/modal_stepper.h"
#include "structure/mechanics/wind_projection.h"

namespace roseau::structure {

/// A rope at a node: its force grows evenly from `start_s` for `ramp_s`, stays, and is gone from `release_s` on. With ramp_s =
/// 0 it acts at once.
struct RopePull {
  std::size_t node = 0;
  Vec3 force_n;
  double start_s = 0;
  double ramp_s = 0;
  double release_s = 0;
};

struct SwayOptions {
  double step_s = 1.0 / 240;
  double start_s = 0;  // time of the wind field at which it begins

  enum class Load { full_integration, projection };
  Load load = Load::full_integration;
  /// With the projection: the mean wind whose aerodynamic damping is added to the modes' own.
  Vec3 mean_wind_mps;

  enum class Stepping { exact, semi_implicit };
  Stepping stepping = Stepping::exact;

  enum class Start { at_rest, in_equilibrium };  // with the wind and the rope at the beginning
  Start start = Start::in_equilibrium;

  std::vector<RopePull> pulls;
};

/// Not for several threads at once.
class SwaySimulation {
 public:
  /// `wind` is kept by reference and must outlive the simulation. `load` belongs to `model`.
  /// Error (invalid_argument): a step that is not above zero, or too long for semi-implicit stepping; a pull on a node that
  /// does not exist, or whose times are not in order.
  static Result<SwaySimulation> make(ModalModel model, DragLoad load, const WindField& wind, const SwayOptions& options);

  /// One step of the options' length.
  void advance();

  /// The state at time_s(), the end of the last step.
  const ModalState& state() const { return state_; }
  double time_s() const { return time_at(step_count_); }
  double step_s() const { return options_.step_s; }

  /// Where it stands, to come back to: what follows is the same to the bit, as long as parameters are the same.
  struct Checkpoint {
    std::uint64_t step_count = 0;
    ModalState state;
    Eigen::VectorXd wind_force;
  };
  Checkpoint checkpoint() const { return {step_count_, state_, force_}; }
  void resume(const Checkpoint& checkpoint);

  /// The state at any time of the last step (or at its ends): with exact stepping as exact as the step itself.
  ModalState state_at(double time_s) const;

  /// Of the wind at time_s(): under the relative velocity of the tree. Ropes apart.
  const Eigen::VectorXd& wind_force() const { return force_; }
  /// Of the ropes at time_s(), just after it where one is let go then.
  Eigen::VectorXd rope_force() const;

  /// Changes parameters from the next step on. Errors: those of ModalModel::set_parameters() and make().
  Result<void> set_parameters(const ModalParameters& parameters);

  const ModalModel& model() const { return model_; }
  const DragLoad& load() const { return load_; }

 private:
  /// A rope's force in modal terms, and the times at which it is not straight.
  struct Rope {
    RopePull pull;
    Eigen::VectorXd force;

    double share_before(double time_s) const;  // limit from below
    double share_after(double time_s) const;   // limit from above
  };

  SwaySimulation(ModalModel model, DragLoad load, const WindField& wind, SwayOptions options);
  Result<void> make_stepper();
  double time_at(std::uint64_t step) const { return options_.start_s + static_cast<double>(step) * options_.step_s; }
  void sample_wind(double time_s);
  void drag(const Eigen::VectorXd& q_dot, Eigen::VectorXd& force);
  void advance_exactly();
  void advance_semi_implicitly(const SemiImplicitStepper& stepper);
  void propagate(double from_s, double to_s, const Eigen::VectorXd& begin_force, const Eigen::VectorXd& end_force,
                 ModalState& state) const;
  void add_ropes(double time_s, double (Rope::*share)(double) const, Eigen::VectorXd& force) const;
  void find_breaks(double from_s, double to_s, std::vector<double>& breaks) const;

  ModalModel model_;
  DragLoad load_;
  const WindField* wind_;
  SwayOptions options_;
  WindProjection projection_;
  std::vector<Rope> ropes_;
  std::variant<std::monostate, ExactStepper, SemiImplicitStepper> stepper_;

  std::uint64_t step_count_ = 0;
  ModalState state_;
  Eigen::VectorXd force_;
  // Of the last step: where it began, and the wind's modal force at both ends.
  ModalState begin_state_;
  Eigen::VectorXd begin_force_;
  Eigen::VectorXd end_force_;
  std::vector<Vec3> air_mps_;
  Vec3 centre_air_mps_;
};

}  // namespace roseau::structure
