#include "structure/animation/large_amplitude.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/check.h"

namespace roseau::structure {

namespace {

// b is searched as b times the largest |q|: from a curve that arctan does not bend to one that is nearly a step.
constexpr double kLeastBend = 0.02;
constexpr double kMostBend = 30;
constexpr int kCoarseBends = 40;
constexpr int kRefinements = 30;
constexpr double kOvershoot = 2;       // of an undamped oscillator, when a wind sets in at once
constexpr double kLeastMotion = 0.05;  // of the mode that moves farthest, for those that this wind hardly moves
constexpr double kNegligible = 1e-9;   // of the mode's farthest motion: nodes that are held

Error invalid(std::string message) {
  return {ErrorCode::invalid_argument, "large-amplitude correction: " + std::move(message)};
}

double largest(std::span<const double> q) {
  double most = 0;
  for (const double value : q) most = std::max(most, std::abs(value));
  return most;
}

// Orthonormal columns that span the samples of s and s^2.
Eigen::MatrixX2d function_space(std::span<const double> q, double b) {
  Eigen::MatrixX2d functions(static_cast<Eigen::Index>(q.size()), 2);
  for (std::size_t j = 0; j < q.size(); ++j) {
    const double s = corrected_coordinate(q[j], b);
    functions.row(static_cast<Eigen::Index>(j)) << s, s * s;
  }
  functions.col(0).normalize();
  functions.col(1) -= functions.col(0).dot(functions.col(1)) * functions.col(0);
  functions.col(1).normalize();
  return functions;
}

// The b that explains most: a coarse scan, as there may be several maxima, then golden sections about the best.
template <class Explained>
double search_bend(const Explained& explained) {
  const double step = std::log(kMostBend / kLeastBend) / (kCoarseBends - 1);
  int best = 0;
  double best_value = -1;
  for (int i = 0; i < kCoarseBends; ++i) {
    const double value = explained(kLeastBend * std::exp(step * i));
    if (value > best_value) {
      best = i;
      best_value = value;
    }
  }
  constexpr double kGolden = 0.6180339887498949;
  double low = std::log(kLeastBend) + step * (best - 1);
  double high = low + 2 * step;
  const auto at_log = [&](double log_bend) { return explained(std::exp(log_bend)); };
  double left = high - kGolden * (high - low);
  double right = low + kGolden * (high - low);
  double left_value = at_log(left);
  double right_value = at_log(right);
  for (int i = 0; i < kRefinements; ++i) {
    if (left_value > right_value) {
      high = std::exchange(right, left);
      right_value = left_value;
      left_value = at_log(left = high - kGolden * (high - low));
    } else {
      low = std::exchange(left, right);
      left_value = right_value;
      right_value = at_log(right = low + kGolden * (high - low));
    }
  }
  const double bend = std::exp((low + high) / 2);
  // No bend at all is the simplest explanation: kept where arctan explains nothing more.
  return explained(bend) > explained(0) * (1 + 1e-13) ? bend : 0;
}

// Fewer rows that explain the same: what a search compares depends on the products of the columns alone.
Eigen::MatrixXd condensed(const Eigen::Ref<const Eigen::MatrixXd>& displacement_m) {
  if (displacement_m.rows() <= displacement_m.cols()) return displacement_m;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(displacement_m);
  return qr.matrixQR().topRows(displacement_m.cols()).triangularView<Eigen::Upper>();
}

std::vector<double> sample_amplitudes(double range, std::size_t samples) {
  std::vector<double> q(samples);
  for (std::size_t j = 0; j < samples; ++j) {
    q[j] = range * (2 * static_cast<double>(j) / static_cast<double>(samples - 1) - 1);
  }
  return q;
}

// The mode's deformations with lengths kept, a column per amplitude.
Eigen::MatrixXd sample_deformations(const Skeleton& skeleton, const Eigen::Ref<const Eigen::VectorXd>& shape,
                                    std::span<const double> q) {
  Eigen::MatrixXd displacement_m(shape.size(), static_cast<Eigen::Index>(q.size()));
  for (std::size_t j = 0; j < q.size(); ++j) {
    const auto column = static_cast<Eigen::Index>(j);
    displacement_m.col(column) = q[j] * shape;
    keep_lengths(skeleton, displacement_m.col(column));
  }
  return displacement_m;
}

Result<void> check_input(const Skeleton& skeleton, const Eigen::MatrixXd& shapes, std::span<const double> range,
                         const CorrectionOptions& options) {
  const auto nodes = static_cast<Eigen::Index>(skeleton.parents.size());
  if (nodes == 0 || shapes.cols() == 0) return invalid("there is no node or no mode");
  if (skeleton.rest_m.size() != 3 * nodes || shapes.rows() != 3 * nodes) {
    return invalid(fmt::format("{} nodes have a parent, but there are {} coordinates at rest and {} per shape", nodes,
                               skeleton.rest_m.size(), shapes.rows()));
  }
  if (range.size() != static_cast<std::size_t>(shapes.cols())) {
    return invalid(fmt::format("{} modes, but {} amplitude ranges", shapes.cols(), range.size()));
  }
  for (std::size_t n = 0; n < skeleton.parents.size(); ++n) {
    if (std::cmp_greater_equal(skeleton.parents[n], n)) {
      return invalid(fmt::format("node {} comes before its parent {}", n, skeleton.parents[n]));
    }
  }
  for (std::size_t i = 0; i < range.size(); ++i) {
    if (!(range[i] > 0) || !std::isfinite(range[i])) {
      return invalid(fmt::format("the amplitude range of mode {} is {}; it must be positive", i, range[i]));
    }
  }
  if (options.samples < 5) return invalid("fewer than 5 amplitudes do not fix a curve");
  if (!skeleton.rest_m.allFinite() || !shapes.allFinite()) return invalid("a coordinate or a shape is not a finite number");
  return {};
}

// s and s^2 of every mode times their vectors; `bend` gives b for a mode and node.
template <class Bend>
Eigen::VectorXd displace(const Eigen::MatrixXd& v, const Eigen::MatrixXd& w, const Eigen::Ref<const Eigen::VectorXd>& q,
                         const Bend& bend) {
  ROSEAU_CHECK(q.size() == v.cols());
  Eigen::VectorXd displacement_m = Eigen::VectorXd::Zero(v.rows());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    for (Eigen::Index n = 0; n < v.rows() / 3; ++n) {
      const double s = corrected_coordinate(q[i], bend(n, i));
      displacement_m.segment<3>(3 * n) += s * v.block<3, 1>(3 * n, i) + s * s * w.block<3, 1>(3 * n, i);
    }
  }
  return displacement_m;
}

}  // namespace

void keep_lengths(const Skeleton& skeleton, Eigen::Ref<Eigen::VectorXd> displacement_m) {
  ROSEAU_CHECK(displacement_m.size() == skeleton.rest_m.size());
  // From the last node to the first, each displacement becomes the one relative to its parent, with the length kept; then, from
  // the first to the last, they add up again.
  for (std::size_t n = skeleton.parents.size(); n-- > 0;) {
    if (skeleton.parents[n] < 0) continue;
    const auto at = static_cast<Eigen::Index>(3 * n);
    const Eigen::Index parent = 3 * Eigen::Index{skeleton.parents[n]};
    const Eigen::Vector3d at_rest = skeleton.rest_m.segment<3>(at) - skeleton.rest_m.segment<3>(parent);
    const Eigen::Vector3d deformed = at_rest + displacement_m.segment<3>(at) - displacement_m.segment<3>(parent);
    const double length_m = at_rest.norm();
    const double deformed_m = deformed.norm();
    // A node pushed right onto its parent has no line to be pulled along: the segment then stands as at rest.
    const bool has_line = deformed_m > 1e-9 * length_m;
    displacement_m.segment<3>(at) =
        has_line ? Eigen::Vector3d(deformed * (length_m / deformed_m) - at_rest) : Eigen::Vector3d::Zero();
  }
  for (std::size_t n = 0; n < skeleton.parents.size(); ++n) {
    if (skeleton.parents[n] < 0) continue;
    displacement_m.segment<3>(static_cast<Eigen::Index>(3 * n)) +=
        displacement_m.segment<3>(3 * Eigen::Index{skeleton.parents[n]});
  }
}

LengthError length_error(const Skeleton& skeleton, const Eigen::Ref<const Eigen::VectorXd>& displacement_m) {
  LengthError error;
  double total_m = 0;
  double squares = 0;
  for (std::size_t n = 0; n < skeleton.parents.size(); ++n) {
    if (skeleton.parents[n] < 0) continue;
    const auto at = static_cast<Eigen::Index>(3 * n);
    const Eigen::Index parent = 3 * Eigen::Index{skeleton.parents[n]};
    const Eigen::Vector3d at_rest = skeleton.rest_m.segment<3>(at) - skeleton.rest_m.segment<3>(parent);
    const Eigen::Vector3d now = at_rest + displacement_m.segment<3>(at) - displacement_m.segment<3>(parent);
    const double length_m = at_rest.norm();
    if (length_m == 0) continue;
    const double relative = now.norm() / length_m - 1;
    total_m += length_m;
    squares += length_m * relative * relative;
    error.worst = std::max(error.worst, std::abs(relative));
  }
  if (total_m > 0) error.rms = std::sqrt(squares / total_m);
  return error;
}

double corrected_coordinate(double q, double b) { return b > 0 ? std::atan(b * q) / b : q; }

CurveFit fit_curve(std::span<const double> q, const Eigen::Ref<const Eigen::MatrixXd>& displacement_m) {
  ROSEAU_CHECK(q.size() >= 3 && displacement_m.cols() == static_cast<Eigen::Index>(q.size()));
  const double scale = largest(q);
  ROSEAU_CHECK(scale > 0);
  const Eigen::MatrixXd rows = condensed(displacement_m);
  const double bend = search_bend([&](double b) { return (rows * function_space(q, b / scale)).squaredNorm(); });

  CurveFit fit;
  fit.b = bend / scale;
  Eigen::MatrixX2d functions(displacement_m.cols(), 2);
  for (std::size_t j = 0; j < q.size(); ++j) {
    const double s = corrected_coordinate(q[j], fit.b);
    functions.row(static_cast<Eigen::Index>(j)) << s, s * s;
  }
  const Eigen::MatrixXd vectors = functions.colPivHouseholderQr().solve(displacement_m.transpose());
  fit.v = vectors.row(0);
  fit.w = vectors.row(1);
  const double own = displacement_m.norm();
  const double left = (functions * vectors - displacement_m.transpose()).norm();
  fit.residual = own > 0 ? left / own : 0;
  return fit;
}

Eigen::VectorXd LargeAmplitudeCorrection::displacement_m(const Eigen::Ref<const Eigen::VectorXd>& q) const {
  return displace(v, w, q, [&](Eigen::Index, Eigen::Index mode) { return b[mode]; });
}

Eigen::VectorXd NodeWiseCorrection::displacement_m(const Eigen::Ref<const Eigen::VectorXd>& q) const {
  return displace(v, w, q, [&](Eigen::Index node, Eigen::Index mode) { return b(node, mode); });
}

Result<LargeAmplitudeCorrection> fit_correction(const Skeleton& skeleton, const Eigen::MatrixXd& shapes,
                                                std::span<const double> range, const CorrectionOptions& options) {
  if (auto checked = check_input(skeleton, shapes, range, options); !checked) return checked.error();
  LargeAmplitudeCorrection correction{.b = Eigen::VectorXd::Zero(shapes.cols()),
                                      .v = shapes,
                                      .w = Eigen::MatrixXd::Zero(shapes.rows(), shapes.cols()),
                                      .residual = Eigen::VectorXd::Zero(shapes.cols())};
  for (Eigen::Index i = 0; i < shapes.cols(); ++i) {
    const auto q = sample_amplitudes(range[static_cast<std::size_t>(i)], options.samples);
    CurveFit fit = fit_curve(q, sample_deformations(skeleton, shapes.col(i), q));
    correction.b[i] = fit.b;
    correction.v.col(i) = fit.v;
    correction.w.col(i) = fit.w;
    correction.residual[i] = fit.residual;
  }
  return correction;
}

Result<NodeWiseCorrection> fit_node_wise_correction(const Skeleton& skeleton, const Eigen::MatrixXd& shapes,
                                                    std::span<const double> range, const CorrectionOptions& options) {
  if (auto checked = check_input(skeleton, shapes, range, options); !checked) return checked.error();
  NodeWiseCorrection correction{.b = Eigen::MatrixXd::Zero(shapes.rows() / 3, shapes.cols()),
                                .v = shapes,
                                .w = Eigen::MatrixXd::Zero(shapes.rows(), shapes.cols()),
                                .residual = Eigen::VectorXd::Zero(shapes.cols())};
  for (Eigen::Index i = 0; i < shapes.cols(); ++i) {
    const auto q = sample_amplitudes(range[static_cast<std::size_t>(i)], options.samples);
    const Eigen::MatrixXd sampled = sample_deformations(skeleton, shapes.col(i), q);
    const double least_m = kNegligible * sampled.cwiseAbs().maxCoeff();
    double squares = 0;
    for (Eigen::Index n = 0; n < shapes.rows() / 3; ++n) {
      const auto of_node = sampled.middleRows<3>(3 * n);
      if (!(of_node.cwiseAbs().maxCoeff() > least_m)) continue;
      const CurveFit fit = fit_curve(q, of_node);
      correction.b(n, i) = fit.b;
      correction.v.block<3, 1>(3 * n, i) = fit.v;
      correction.w.block<3, 1>(3 * n, i) = fit.w;
      squares += std::pow(fit.residual * of_node.norm(), 2);
    }
    const double own = sampled.norm();
    correction.residual[i] = own > 0 ? std::sqrt(squares) / own : 0;
  }
  return correction;
}

std::vector<double> amplitudes_in_wind(const ModalBasis& basis, double speed_mps) {
  const auto modes = static_cast<Eigen::Index>(basis.mode_count());
  std::vector<double> amplitudes(basis.mode_count());
  Eigen::VectorXd unit_m(modes);  // that each mode's farthest node moves per unit of amplitude
  double farthest_m = 0;
  for (Eigen::Index i = 0; i < modes; ++i) {
    const double omega = 2 * std::numbers::pi * basis.natural_frequency_hz[i];
    const double force = speed_mps * speed_mps * basis.wind_projection.col(i).head<2>().norm();
    const double per_metre = amplitude_for(basis.shapes.col(i), 1);
    unit_m[i] = per_metre > 0 ? 1 / per_metre : 0;
    amplitudes[static_cast<std::size_t>(i)] = kOvershoot * force / (omega * omega);
    farthest_m = std::max(farthest_m, amplitudes[static_cast<std::size_t>(i)] * unit_m[i]);
  }
  for (Eigen::Index i = 0; i < modes; ++i) {
    double& amplitude = amplitudes[static_cast<std::size_t>(i)];
    if (unit_m[i] > 0) amplitude = std::max(amplitude, kLeastMotion * farthest_m / unit_m[i]);
    if (!(amplitude > 0)) amplitude = 1;
  }
  return amplitudes;
}

double amplitude_for(const Eigen::Ref<const Eigen::VectorXd>& shape, double displacement_m) {
  double farthest = 0;
  for (Eigen::Index n = 0; n < shape.size() / 3; ++n) farthest = std::max(farthest, shape.segment<3>(3 * n).norm());
  return farthest > 0 ? displacement_m / farthest : 0;
}

}  // namespace roseau::structure
