#include "structure/mechanics/modal_model.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace roseau::structure {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

Vec3 at_node(const Eigen::MatrixXd& rows, std::size_t node, const Eigen::VectorXd& q) {
  const Eigen::Vector3d value = rows.middleRows(static_cast<Eigen::Index>(3 * node), 3) * q;
  return {value.x(), value.y(), value.z()};
}

bool is_positive(double value) { return std::isfinite(value) && value > 0; }

}  // namespace

RayleighDamping rayleigh_damping(double frequency1_hz, double ratio1, double frequency2_hz, double ratio2) {
  const double w1 = kTwoPi * frequency1_hz;
  const double w2 = kTwoPi * frequency2_hz;
  if (w1 == w2) return {2 * ratio1 * w1, 0};
  const double beta = 2 * (ratio2 * w2 - ratio1 * w1) / (w2 * w2 - w1 * w1);
  return {2 * ratio1 * w1 - beta * w1 * w1, beta};
}

Result<ModalModel> ModalModel::build(const TreeModel& tree, const BeamOptions& beams, const ModeOptions& options,
                                     const ModalParameters& parameters) {
  const double needed = modal_analysis_bytes(tree.nodes.size(), options.mode_count);
  if (needed > options.memory_limit_bytes) {  // before the matrices are made
    return Error{ErrorCode::invalid_argument,
                 fmt::format("tree \"{}\": {} modes of {} nodes need {:.1f} GB, above the limit of {:.1f} GB", tree.name,
                             options.mode_count, tree.nodes.size(), needed / 1e9, options.memory_limit_bytes / 1e9)};
  }
  const std::string context = fmt::format("tree \"{}\"", tree.name);
  const auto structure = assemble_beams(tree, beams);
  if (!structure) return structure.error().with_context(context);
  const auto modes = first_modes(*structure, options);
  if (!modes) return modes.error().with_context(context);
  ModalModel model(*structure, *modes);
  if (auto set = model.set_parameters(parameters); !set) return set.error().with_context(context);
  return model;
}

ModalModel::ModalModel(const BeamStructure& structure, const Modes& modes)
    : node_count_(structure.node_count),
      total_mass_kg_(structure.total_mass_kg()),
      largest_residual_(modes.largest_residual),
      base_stiffness_per_s2_(modes.stiffness_per_s2.array()) {
  const auto rows = static_cast<Eigen::Index>(3 * node_count_);
  translations_ = Eigen::MatrixXd::Zero(rows, modes.shapes.cols());
  rotations_ = translations_;
  for (std::size_t node = 1; node < node_count_; ++node) {
    const auto row = static_cast<Eigen::Index>(3 * node);
    const Eigen::Index dof = structure.first_dof(node);
    translations_.middleRows(row, 3) = modes.shapes.middleRows(dof, 3);
    rotations_.middleRows(row, 3) = modes.shapes.middleRows(dof + 3, 3);
  }
  ROSEAU_CHECK(set_parameters({}).has_value());
}

Result<void> ModalModel::set_parameters(const ModalParameters& parameters) {
  const auto refuse = [](const char* what, double value) {
    return Error{ErrorCode::invalid_argument, fmt::format("{} cannot be {}", what, value)};
  };
  if (!is_positive(parameters.young_modulus_scale))
    return refuse("the scale of Young's modulus", parameters.young_modulus_scale);
  if (!is_positive(parameters.density_scale)) return refuse("the density's scale", parameters.density_scale);
  if (!is_positive(parameters.mass_factor)) return refuse("the mass factor", parameters.mass_factor);
  if (!(std::isfinite(parameters.alpha_per_s) && parameters.alpha_per_s >= 0))
    return refuse("the damping coefficient alpha", parameters.alpha_per_s);
  if (!(std::isfinite(parameters.beta_s) && parameters.beta_s >= 0))
    return refuse("the damping coefficient beta", parameters.beta_s);
  parameters_ = parameters;
  stiffness_per_s2_ = base_stiffness_per_s2_ * (parameters.young_modulus_scale / modal_mass());
  damping_per_s_ = parameters.alpha_per_s + parameters.beta_s * stiffness_per_s2_;
  return {};
}

double ModalModel::natural_frequency_hz(std::size_t mode) const {
  return std::sqrt(stiffness_per_s2_[static_cast<Eigen::Index>(mode)]) / kTwoPi;
}

double ModalModel::damping_ratio(std::size_t mode) const {
  const auto i = static_cast<Eigen::Index>(mode);
  return damping_per_s_[i] / (2 * std::sqrt(stiffness_per_s2_[i]));
}

Eigen::Vector3d ModalModel::translation(std::size_t node, std::size_t mode) const {
  return translations_.block<3, 1>(static_cast<Eigen::Index>(3 * node), static_cast<Eigen::Index>(mode));
}

Vec3 ModalModel::displacement_m(std::size_t node, const Eigen::VectorXd& q) const { return at_node(translations_, node, q); }

Vec3 ModalModel::rotation_rad(std::size_t node, const Eigen::VectorXd& q) const { return at_node(rotations_, node, q); }

Eigen::VectorXd ModalModel::modal_force_at(std::size_t node, const Vec3& force_n) const {
  const Eigen::Vector3d force(force_n.x, force_n.y, force_n.z);
  return translations_.middleRows(static_cast<Eigen::Index>(3 * node), 3).transpose() * force;
}

Eigen::VectorXd ModalModel::static_amplitudes(const Eigen::VectorXd& modal_force) const {
  return modal_force.array() / (stiffness_per_s2_ * modal_mass());
}

}  // namespace roseau::structure
