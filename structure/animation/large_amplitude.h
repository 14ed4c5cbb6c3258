// Large-amplitude correction of modal animation (thesis 6.4.2, equations 6.31-6.35). Phi q stretches branches when they bend
// far. Bent one mode at a time with lengths kept, each node runs along a smooth curve, which is fitted by
//
//     u(q) = s v + s^2 w,   s = a arctan(b q).
//
// Only the product of a with v, and of its square with w, is determined: a = 1/b here, so that s -> q for small motion, v is
// then nearly the linear shape, and b = 0 means s = q.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/result.h"
#include "structure/animation/modal_basis.h"

namespace roseau::structure {

/// A skeleton at rest: 3N coordinates in metres, and each node's parent: an earlier node, or negative for one that is held.
struct Skeleton {
  Eigen::VectorXd rest_m;
  std::vector<std::int32_t> parents;
};

/// The displacement (3N, metres) with every segment's length as at rest. Depth first, each node is pulled towards its parent,
/// and what it bears comes along: segments keep the direction that the displacement gave them. Nodes that stand on their parent
/// follow it; nodes without a parent stay where `displacement_m` has them. Exact for any motion, all modes together; costs a
/// pass over the tree, where the corrections below are a product.
void keep_lengths(const Skeleton& skeleton, Eigen::Ref<Eigen::VectorXd> displacement_m);

/// How far displaced segments are from their lengths at rest, relative: root mean square weighted by length, and the worst.
struct LengthError {
  double rms = 0;
  double worst = 0;
};
LengthError length_error(const Skeleton& skeleton, const Eigen::Ref<const Eigen::VectorXd>& displacement_m);

/// s of 6.32 with a = 1/b.
double corrected_coordinate(double q, double b);

/// The curves u(q) = s v + s^2 w with one b for all that come closest to sampled ones in the sense of least squares.
struct CurveFit {
  double b = 0;
  Eigen::VectorXd v;
  Eigen::VectorXd w;
  double residual = 0;  // root mean square error relative to the samples' own root mean square
};
/// `displacement_m`: a column per q. The q are not all zero and not fewer than three.
CurveFit fit_curve(std::span<const double> q, const Eigen::Ref<const Eigen::MatrixXd>& displacement_m);

/// One b per mode: 2 functions of time per mode, so that the displacement of all nodes is again a matrix product.
struct LargeAmplitudeCorrection {
  Eigen::VectorXd b;  // M, per unit of q
  Eigen::MatrixXd v;  // 3N x M
  Eigen::MatrixXd w;  // 3N x M
  /// Per mode: root mean square of the fit's error over nodes and amplitudes, relative to the motion's own.
  Eigen::VectorXd residual;

  Eigen::VectorXd displacement_m(const Eigen::Ref<const Eigen::VectorXd>& q) const;
};

/// A b for every node and mode, as printed in 6.35: more exact, at one arctan per node, mode and frame.
struct NodeWiseCorrection {
  Eigen::MatrixXd b;  // N x M
  Eigen::MatrixXd v;
  Eigen::MatrixXd w;
  Eigen::VectorXd residual;

  Eigen::VectorXd displacement_m(const Eigen::Ref<const Eigen::VectorXd>& q) const;
};

struct CorrectionOptions {
  std::size_t samples = 33;  // amplitudes per mode, evenly from -range to range
};

/// `range[i]`: the largest |q_i| that the correction is made for. Beyond it the curves run on smoothly, no longer
/// fitted: choose it for the strongest wind. Refused: sizes that do
/// not fit, a parent that comes after its child, a range that is not positive, fewer than 5 samples.
Result<LargeAmplitudeCorrection> fit_correction(const Skeleton& skeleton, const Eigen::MatrixXd& shapes,
                                                std::span<const double> range, const CorrectionOptions& options = {});
Result<NodeWiseCorrection> fit_node_wise_correction(const Skeleton& skeleton, const Eigen::MatrixXd& shapes,
                                                    std::span<const double> range, const CorrectionOptions& options = {});

/// Ranges for trees that will stand in gusts up to this speed from any side: twice the deflection that a steady wind gives each
/// mode (an undamped tree overshoots so far when it sets in at once), and a little for modes that it hardly moves.
std::vector<double> amplitudes_in_wind(const ModalBasis& basis, double speed_mps);

/// The amplitude at which the mode moves its farthest node by this much, for `range`. Zero for a mode that moves nothing.
double amplitude_for(const Eigen::Ref<const Eigen::VectorXd>& shape, double displacement_m);

}  // namespace roseau::structure
