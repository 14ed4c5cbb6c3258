// The wind's push on a tree, integrated over all of its wood and leaves (thesis 6.3): per metre of wood
//
//   f(p, t) = 1/2 rho C_D D(p) |v - p'| (v - p')      (6.23)      f_i = integral of f . phi_i      (6.24, 6.25)
//
// and on the leaves of each node the same with their area in the place of D dp. Streamlining: a law of exponent n = 2 + Vogel
// exponent has |v|^(n - 1) v in the place of |v| v, scaled so that both laws agree at the reference speed.
//
// Wood is integrated with two Gauss points in each segment, made for the weight D(p), the segment's own taper: exact for any
// wind that does not change along a segment, since the shapes are cubic.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry.h"
#include "core/result.h"
#include "structure/mechanics/modal_model.h"
#include "structure/tree/tree_model.h"

namespace roseau::structure {

struct DragOptions {
  double air_density_kg_m3 = 1.2;
  double wood_coefficient = 1;       // C_D, for the diameter
  double foliage_coefficient = 0.5;  // C_D, for one side of the blades
  /// Above -2 and at most 0. 0: rigid, force with the square of the speed; -1: streamlined, force with the speed itself.
  double wood_vogel_exponent = 0;
  double foliage_vogel_exponent = 0;
  double reference_speed_mps = 5;  // where a law with a Vogel exponent equals the one without
  bool relative_velocity = true;   // v - p' rather than v: brings the aerodynamic damping
  Vec3 foot_in_world_m;            // where the tree stands; its axes are the world's
};

/// Derivative of |v|^(n - 1) v by v: what turns a small velocity of the tree into a change of the drag. In still air: zero, but
/// for n = 1; laws below that have none there.
Eigen::Matrix3d drag_slope(const Vec3& air_mps, double exponent);

/// Not for several threads at once: it keeps room for its own intermediate results.
class DragLoad {
 public:
  /// `tree` is the one that `model` was made of. Error (invalid_argument): an option without meaning; names it.
  static Result<DragLoad> build(const TreeModel& tree, const ModalModel& model, const DragOptions& options);

  /// Where the wind has to be known: the Gauss points of the wood, then every node with leaves, all at rest.
  std::span<const Vec3> points_in_world() const { return points_; }
  std::size_t wood_point_count() const { return wood_.count; }
  std::size_t mode_count() const { return static_cast<std::size_t>(mode_count_); }

  /// Modal forces (f of 6.17 before the division by m) under the air's velocity at points_in_world(), for a tree that moves
  /// with q_dot. `force` gets mode_count() values. No allocation.
  void modal_force(std::span<const Vec3> air_mps, const Eigen::VectorXd& q_dot, Eigen::VectorXd& force);

  /// Linearised about a steady wind: what the drag takes from the tree's motion, f_i = f_i(rest) - sum of C_ij q_dot_j.
  /// Symmetric and positive. In units of the modal force: divide by the modal mass for a damping coefficient. Zero without
  /// relative velocity.
  Eigen::MatrixXd damping_matrix(std::span<const Vec3> mean_air_mps) const;
  Eigen::MatrixXd damping_matrix(const Vec3& uniform_air_mps) const;

  /// Integrals for the wind projection: of wood and of foliage apart, since their exponents may differ.
  struct Part {
    double exponent = 2;      // n
    Eigen::Matrix3Xd push;    // column i: p_i of 6.29, that is, the sum of weight phi_i
    Eigen::MatrixXd damping;  // column i: the sum of weight phi_i phi_i^T, a 3x3 tensor column by column
    double weight = 0;        // sum of 1/2 rho C_D D dp v_ref^(2 - n)
    Vec3 centre_in_world;     // weighted mean of the points
  };
  Part wood() const { return integrate(wood_); }
  Part foliage() const { return integrate(foliage_); }
  bool has_relative_velocity() const { return relative_velocity_; }

 private:
  static constexpr Eigen::Index kBlock = 32;  // points handled together: their shapes of 25 modes fit a first-level cache
  static constexpr Eigen::Index kRows = 3 * kBlock;

  struct Group {
    double exponent = 2;
    std::size_t first = 0;  // in points_
    std::size_t count = 0;
    Eigen::ArrayXd weight;   // 1/2 rho C_D D dp v_ref^(2 - n), padded with zeros to whole blocks
    Eigen::MatrixXd shapes;  // kRows x (blocks * modes): of each block, all its x, then y, then z
  };

  DragLoad() = default;
  void fill(Group& group, std::span<const double> weight, const Eigen::MatrixXd& rows) const;
  void add_force(const Group& group, std::span<const Vec3> air_mps, const Eigen::VectorXd& q_dot, Eigen::VectorXd& force);
  void add_damping(const Group& group, std::span<const Vec3> air_mps, Eigen::MatrixXd& damping) const;
  Part integrate(const Group& group) const;

  Eigen::Index mode_count_ = 0;
  bool relative_velocity_ = true;
  std::vector<Vec3> points_;
  Group wood_;
  Group foliage_;
  Eigen::VectorXd relative_ = Eigen::VectorXd::Zero(kRows);  // of one block: velocity of the air past the tree, then the drag
  Eigen::ArrayXd factor_ = Eigen::ArrayXd::Zero(kBlock);
};

}  // namespace roseau::structure
