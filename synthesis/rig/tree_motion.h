// TreeMotion: how the scene's tree moves, as a function of time. Every device of a rig asks the same one, from its own thread,
// and the work is done once: the motion is computed piece by piece on a fixed grid of steps; the last pieces are kept, and the
// state at the beginning of some older ones, so that any time can be asked for again.
//
// What it answers does not depend on who asked for what before, to the bit.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>

#include "structure/mechanics/sway_simulation.h"

namespace roseau::synthesis {

class TreeMotion {
 public:
  /// `simulation` stands at its beginning, which is before time 0 by as long as its start takes to be forgotten.
  explicit TreeMotion(structure::SwaySimulation simulation);

  const structure::ModalModel& model() const { return simulation_.model(); }

  /// Amplitudes q of the modes at a time not before the simulation's beginning. Between two steps: the cubic through amplitudes
  /// and rates at both, which is off by less than (w h)^4 / 384 of a mode's amplitude. Thread-safe.
  void amplitudes(double time_s, Eigen::VectorXd& q) const;

  /// Modal forces of wind and ropes, linear between steps. Thread-safe.
  void forces(double time_s, Eigen::VectorXd& force) const;

 private:
  // The states at steps [first, first + kPieceSteps], a column each.
  struct Piece {
    Eigen::MatrixXd q;
    Eigen::MatrixXd q_dot;
    Eigen::MatrixXd force;
  };
  struct Place {
    std::shared_ptr<const Piece> piece;
    Eigen::Index column = 0;
    double share = 0;  // of the step after the column
  };

  Place place(double time_s) const;
  std::shared_ptr<const Piece> piece(std::int64_t number) const;
  std::shared_ptr<const Piece> compute_piece(std::int64_t number) const;

  double start_s_;
  double step_s_;
  mutable std::mutex mutex_;
  mutable structure::SwaySimulation simulation_;
  mutable std::int64_t next_piece_ = 0;  // the one at whose beginning the simulation stands
  mutable std::map<std::int64_t, std::shared_ptr<const Piece>> recent_;
  mutable std::map<std::int64_t, structure::SwaySimulation::Checkpoint> checkpoints_;
};

}  // namespace roseau::synthesis
