#include "structure/mechanics/sway_truth.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <tuple>

#include "structure/tree/vector3.h"

namespace roseau::structure {
namespace {

/// State matrix of (q, q').
Eigen::MatrixXd state_matrix(const ModalModel& model, const Eigen::MatrixXd& aerodynamic_damping) {
  const Eigen::Index n = aerodynamic_damping.rows();
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  matrix.topRightCorner(n, n).setIdentity();
  matrix.bottomLeftCorner(n, n).diagonal() = -model.stiffness_per_s2().matrix();
  matrix.bottomRightCorner(n, n) = -aerodynamic_damping / model.modal_mass();
  matrix.bottomRightCorner(n, n).diagonal() -= model.damping_coefficient_per_s().matrix();
  return matrix;
}

/// Two roots that belong together, and their common shape in terms of the modes.
struct RootPair {
  std::complex<double> first;
  std::complex<double> second;
  Eigen::VectorXd likeness;  // to each mode: size of its amplitude, together 1
};

/// Complex roots with their conjugates; real ones (of overdamped modes) with the real one of the most similar shape.
std::vector<RootPair> pair_roots(const Eigen::EigenSolver<Eigen::MatrixXd>& solver) {
  const Eigen::VectorXcd& roots = solver.eigenvalues();
  const Eigen::MatrixXcd shapes = solver.eigenvectors().topRows(roots.size() / 2).colwise().normalized();
  std::vector<RootPair> pairs;
  std::vector<Eigen::Index> real;
  for (Eigen::Index i = 0; i < roots.size(); ++i) {
    if (roots[i].imag() > 0) pairs.push_back({roots[i], std::conj(roots[i]), shapes.col(i).cwiseAbs()});
    if (roots[i].imag() == 0) real.push_back(i);
  }
  while (real.size() > 1) {
    const Eigen::Index first = real.back();
    real.pop_back();
    const auto similar = [&](Eigen::Index a) { return std::abs(shapes.col(first).dot(shapes.col(a))); };
    const auto second = std::ranges::max_element(real, {}, similar);
    pairs.push_back({roots[first], roots[*second], shapes.col(first).cwiseAbs()});
    real.erase(second);
  }
  return pairs;
}

/// Which pair each mode has become: the clearest likeness is given away first.
std::vector<std::size_t> assign(const std::vector<RootPair>& pairs) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> candidates;
  for (std::size_t pair = 0; pair < pairs.size(); ++pair) {
    for (std::size_t mode = 0; mode < pairs.size(); ++mode) {
      candidates.emplace_back(-pairs[pair].likeness[static_cast<Eigen::Index>(mode)], mode, pair);
    }
  }
  std::ranges::sort(candidates);
  constexpr auto kNone = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> pair_of_mode(pairs.size(), kNone);
  std::vector<bool> taken(pairs.size(), false);
  for (const auto& [likeness, mode, pair] : candidates) {
    if (taken[pair] || pair_of_mode[mode] != kNone) continue;
    pair_of_mode[mode] = pair;
    taken[pair] = true;
  }
  return pair_of_mode;
}

}  // namespace

DominantMode dominant_mode(const ModalModel& model, std::size_t node, const Vec3& direction,
                           const Eigen::VectorXd& modal_force) {
  const Vec3 along = unit(direction);
  const Eigen::ArrayXd seen = model.modal_force_at(node, along).array();  // phi_i(node) . direction
  const Eigen::ArrayXd contribution = (seen * modal_force.array() / model.stiffness_per_s2()).abs();
  Eigen::Index mode = 0;
  const double largest = contribution.maxCoeff(&mode);
  const double sum = contribution.sum();
  return {static_cast<std::size_t>(mode), sum > 0 ? largest / sum : 0};
}

std::vector<LinearisedMode> linearised_modes(const ModalModel& model, const Eigen::MatrixXd& aerodynamic_damping) {
  ROSEAU_CHECK(aerodynamic_damping.rows() == static_cast<Eigen::Index>(model.mode_count()) &&
               aerodynamic_damping.cols() == aerodynamic_damping.rows());
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(state_matrix(model, aerodynamic_damping));
  const std::vector<RootPair> pairs = pair_roots(solver);
  ROSEAU_CHECK(pairs.size() == model.mode_count());
  std::vector<LinearisedMode> modes;
  for (const std::size_t index : assign(pairs)) {
    // s1 s2 = w^2 and s1 + s2 = -2 zeta w, for a complex pair and for two real roots alike.
    const RootPair& pair = pairs[index];
    const double w = std::sqrt(std::abs(pair.first * pair.second));
    modes.push_back({w / (2 * std::numbers::pi), -(pair.first + pair.second).real() / (2 * w)});
  }
  return modes;
}

Vec3 equivalent_static_displacement_m(const ModalModel& model, std::size_t node, const Eigen::VectorXd& modal_force) {
  return model.displacement_m(node, model.static_amplitudes(modal_force));
}

}  // namespace roseau::structure
