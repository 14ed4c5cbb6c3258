#include "synthesis/rig/tree_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/check.h"

namespace roseau::synthesis {

namespace {
constexpr Eigen::Index kPieceSteps = 64;           // a quarter of a second at the usual rate
constexpr std::size_t kRecentPieces = 128;         // half a minute: devices lie less than that apart
constexpr std::int64_t kPiecesPerCheckpoint = 64;  // going back costs at most the computing of so many
}  // namespace

TreeMotion::TreeMotion(structure::SwaySimulation simulation)
    : start_s_(simulation.time_s()), step_s_(simulation.step_s()), simulation_(std::move(simulation)) {
  checkpoints_.emplace(0, simulation_.checkpoint());
}

std::shared_ptr<const TreeMotion::Piece> TreeMotion::compute_piece(std::int64_t number) const {
  if (number < next_piece_) {
    const auto before = std::prev(checkpoints_.upper_bound(number));
    simulation_.resume(before->second);
    next_piece_ = before->first;
  }
  std::shared_ptr<const Piece> computed;
  while (next_piece_ <= number) {
    const auto modes = static_cast<Eigen::Index>(model().mode_count());
    auto piece = std::make_shared<Piece>();
    for (auto* part : {&piece->q, &piece->q_dot, &piece->force}) part->resize(modes, kPieceSteps + 1);
    for (Eigen::Index step = 0; step <= kPieceSteps; ++step) {
      if (step > 0) simulation_.advance();
      piece->q.col(step) = simulation_.state().q;
      piece->q_dot.col(step) = simulation_.state().q_dot;
      piece->force.col(step) = simulation_.wind_force() + simulation_.rope_force();
    }
    recent_[next_piece_] = piece;
    if (++next_piece_ % kPiecesPerCheckpoint == 0) checkpoints_.try_emplace(next_piece_, simulation_.checkpoint());
    computed = std::move(piece);
  }
  // The ones furthest from here are forgotten first.
  while (recent_.size() > kRecentPieces) {
    const bool first_is_further = number - recent_.begin()->first > recent_.rbegin()->first - number;
    recent_.erase(first_is_further ? recent_.begin() : std::prev(recent_.end()));
  }
  return computed;
}

std::shared_ptr<const TreeMotion::Piece> TreeMotion::piece(std::int64_t number) const {
  const std::scoped_lock lock(mutex_);
  if (const auto found = recent_.find(number); found != recent_.end()) return found->second;
  return compute_piece(number);
}

TreeMotion::Place TreeMotion::place(double time_s) const {
  const double steps = std::max(0.0, (time_s - start_s_) / step_s_);
  ROSEAU_CHECK(std::isfinite(steps));
  const auto step = static_cast<std::int64_t>(steps);
  return {.piece = piece(step / kPieceSteps), .column = step % kPieceSteps, .share = steps - static_cast<double>(step)};
}

void TreeMotion::amplitudes(double time_s, Eigen::VectorXd& q) const {
  const auto [piece, column, s] = place(time_s);
  // Hermite's cubic basis (plant thesis, appendix, as corrected in docs/errata.md).
  const double h00 = (1 + 2 * s) * (1 - s) * (1 - s);
  const double h10 = s * (1 - s) * (1 - s);
  const double h01 = s * s * (3 - 2 * s);
  const double h11 = s * s * (s - 1);
  q = h00 * piece->q.col(column) + h01 * piece->q.col(column + 1) +
      step_s_ * (h10 * piece->q_dot.col(column) + h11 * piece->q_dot.col(column + 1));
}

void TreeMotion::forces(double time_s, Eigen::VectorXd& force) const {
  const auto [piece, column, s] = place(time_s);
  force = (1 - s) * piece->force.col(column) + s * piece->force.col(column + 1);
}

}  // namespace roseau::synthesis
