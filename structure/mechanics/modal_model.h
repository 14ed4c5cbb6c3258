// ModalModel: a tree reduced to its first modes (thesis 6.2.2): each an oscillator
//
//   q'' + gamma q' + w^2 q = f / m      u = sum of q_i phi_i      (6.15, 6.17, 6.18)
//
// with mass-normalised shapes, so that q is in metres times the root of a kilogram and m, the modal mass, is a plain factor:
// one until the parameters below scale the mass.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "core/geometry.h"
#include "core/result.h"
#include "structure/mechanics/beam_structure.h"
#include "structure/mechanics/modes.h"
#include "structure/tree/tree_model.h"

namespace roseau::structure {

/// What can be changed at run time, without a new search for modes (thesis 6.4.3).
struct ModalParameters {
  double young_modulus_scale = 1;  // w^2 grows with it
  double density_scale = 1;        // of all that has mass: wood, leaves and point masses; w^2 falls with it
  double mass_factor = 1;          // m of 6.36: acts as the density's scale, kept apart as the animator's control
  double alpha_per_s = 0.1;        // damping C = alpha M + beta K of the scaled matrices (6.11): gamma = alpha + beta w^2
  double beta_s = 0.001;
};

/// The alpha and beta that give two modes these damping ratios; with both at one frequency, all damping goes by the mass.
struct RayleighDamping {
  double alpha_per_s = 0;
  double beta_s = 0;
};
RayleighDamping rayleigh_damping(double frequency1_hz, double ratio1, double frequency2_hz, double ratio2);

class ModalModel {
 public:
  /// Assembles the tree and finds its modes. Errors: those of assemble_beams(), first_modes() and set_parameters().
  static Result<ModalModel> build(const TreeModel& tree, const BeamOptions& beams, const ModeOptions& modes,
                                  const ModalParameters& parameters = {});

  /// From modes found before.
  ModalModel(const BeamStructure& structure, const Modes& modes);

  /// Error (invalid_argument): a scale or factor that is not above zero, a negative damping coefficient.
  Result<void> set_parameters(const ModalParameters& parameters);
  const ModalParameters& parameters() const { return parameters_; }

  std::size_t mode_count() const { return static_cast<std::size_t>(base_stiffness_per_s2_.size()); }
  std::size_t node_count() const { return node_count_; }

  /// Per mode, with the parameters in force.
  const Eigen::ArrayXd& stiffness_per_s2() const { return stiffness_per_s2_; }               // w^2
  const Eigen::ArrayXd& damping_coefficient_per_s() const { return damping_per_s_; }         // gamma
  double natural_frequency_hz(std::size_t mode) const;                                       // w / 2 pi
  double damping_ratio(std::size_t mode) const;                                              // gamma / 2 w
  double modal_mass() const { return parameters_.density_scale * parameters_.mass_factor; }  // m, the same for every mode

  /// Columns are modes. Row 3 * node + axis: displacement in m, or rotation vector in rad, per unit of q. Node 0 stands still.
  const Eigen::MatrixXd& translations() const { return translations_; }
  const Eigen::MatrixXd& rotations() const { return rotations_; }
  Eigen::Vector3d translation(std::size_t node, std::size_t mode) const;

  /// Displacement and rotation vector of a node for modal amplitudes q (6.22).
  Vec3 displacement_m(std::size_t node, const Eigen::VectorXd& q) const;
  Vec3 rotation_rad(std::size_t node, const Eigen::VectorXd& q) const;

  /// Modal force (f of 6.24) of a force in newtons at a node.
  Eigen::VectorXd modal_force_at(std::size_t node, const Vec3& force_n) const;

  /// Amplitudes in equilibrium with a constant modal force: q_i = f_i / (m w_i^2).
  Eigen::VectorXd static_amplitudes(const Eigen::VectorXd& modal_force) const;

  double total_mass_kg() const { return total_mass_kg_ * modal_mass(); }
  /// How well the modes hold, see Modes.
  double largest_residual() const { return largest_residual_; }

 private:
  std::size_t node_count_ = 0;
  double total_mass_kg_ = 0;
  double largest_residual_ = 0;
  Eigen::ArrayXd base_stiffness_per_s2_;
  Eigen::MatrixXd translations_;
  Eigen::MatrixXd rotations_;
  ModalParameters parameters_;
  Eigen::ArrayXd stiffness_per_s2_;
  Eigen::ArrayXd damping_per_s_;
};

}  // namespace roseau::structure
