// ModalBasis: what the animation needs to know of a tree's dynamics (thesis 6.2.2, 6.3). Each mode i is an oscillator
//
//     q'' + gamma_i q' + (2 pi f_i)^2 q = |v| v . p_i        (6.17 with 6.30, modal mass 1)
//
// and the tree's nodes are displaced by Phi q (6.22). v is the wind at the tree, in the tree's own frame.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "core/result.h"

namespace roseau::structure {

struct ModalBasis {
  Eigen::MatrixXd shapes;                // Phi, 3N x M: x, y, z of the first node, of the second, ...; metres per unit of q
  Eigen::VectorXd natural_frequency_hz;  // M
  Eigen::VectorXd damping_coefficient_per_s;  // gamma, M
  Eigen::Matrix3Xd wind_projection;           // p_i, 3 x M: modal force per modal mass, in a wind of 1 m/s along each axis

  std::size_t node_count() const { return static_cast<std::size_t>(shapes.rows()) / 3; }
  std::size_t mode_count() const { return static_cast<std::size_t>(shapes.cols()); }
};

/// Says which part does not fit the others: no node, no mode, lengths that differ, a number that is not finite, a frequency
/// that is not positive or a damping that is negative.
Result<void> check(const ModalBasis& basis);

}  // namespace roseau::structure
