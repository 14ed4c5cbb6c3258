// The first natural modes of a structure: K phi = w^2 M phi (thesis 6.2.2, 6.14).
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "core/result.h"
#include "structure/mechanics/beam_structure.h"

namespace roseau::structure {

struct ModeOptions {
  std::size_t mode_count = 25;
  double memory_limit_bytes = 4e9;  // what the analysis may need; larger ones are refused before they start
};

struct Modes {
  Eigen::VectorXd stiffness_per_s2;  // w^2 in rad^2/s^2, ascending
  Eigen::MatrixXd shapes;            // column i: mode i in the structure's degrees of freedom, phi^T M phi = 1
  double largest_residual =
      0;  // largest over the modes of |phi - w^2 K^-1 M phi| in the norm of M: bounds the relative error of w^2
  double largest_imbalance = 0;  // largest over the modes of ||K phi - w^2 M phi|| / || |K| |phi| ||
};

/// What assembling and analysing a tree of this size takes at its peak.
double modal_analysis_bytes(std::size_t node_count, std::size_t mode_count);

/// Shift-invert Lanczos about zero frequency (Spectra) with Eigen's simplicial LDLT of K. That no mode was left out, which
/// Lanczos can do where two have one frequency (every round trunk: once in x, once in y), is proved by counting: the negative
/// pivots of K - s M are the modes below s. Missing ones are searched for beside those found.
///
/// Deterministic: the start vector is fixed, each mode's sign makes its largest displacement positive, and modes of one
/// frequency are turned so that motion in x comes first, then y.
///
/// Error (invalid_argument): more modes than the structure has degrees of freedom; K is singular, that is, something is not
/// held (names the node); more memory needed than the limit. Error (unsupported): no convergence, or a residual above 1e-6.
Result<Modes> first_modes(const BeamStructure& structure, const ModeOptions& options);

}  // namespace roseau::structure
