#include "structure/mechanics/modes.h"

#include <fmt/format.h>

#include <Spectra/MatOp/SparseSymMatProd.h>
#include <Spectra/SymGEigsShiftSolver.h>
#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace roseau::structure {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;
// The degrees of freedom are numbered so that nothing fills in: no reordering.
using Factorisation = Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>>;

constexpr Eigen::Index kDenseSize = 120;     // up to here all modes at once are cheaper than an iteration
constexpr double kSameFrequency = 1e-7;      // relative gap of w^2 below which modes are treated as one frequency
constexpr double kRestartTolerance = 1e-10;  // of Lanczos, for its residuals: w^2 is good to their square
constexpr double kAcceptedResidual = 1e-6;   // the figure we promise for w^2
constexpr int kMaximumSearches = 8;          // for modes that Lanczos left out
constexpr Eigen::Index kMaximumRestarts = 1000;

/// y = K^-1 x without its part along the modes that are found already (M-orthogonal): Spectra's operator for shift zero.
class InverseStiffness {
 public:
  using Scalar = double;

  InverseStiffness(const Factorisation& factorisation, const SparseMatrix& mass) : factorisation_(factorisation), mass_(mass) {}

  void leave_out(const Eigen::MatrixXd& found) {
    found_ = found;
    mass_found_ = mass_ * found;
  }

  Eigen::Index rows() const { return mass_.rows(); }
  Eigen::Index cols() const { return mass_.cols(); }
  void set_shift(double /*sigma*/) {}  // always zero

  void perform_op(const double* in, double* out) const {
    const Eigen::Map<const Eigen::VectorXd> x(in, rows());
    Eigen::Map<Eigen::VectorXd> y(out, rows());
    y = factorisation_.solve(x);
    if (found_.cols() > 0) y -= found_ * (mass_found_.transpose() * y);
  }

 private:
  const Factorisation& factorisation_;
  const SparseMatrix& mass_;
  Eigen::MatrixXd found_;
  Eigen::MatrixXd mass_found_;
};

struct Pairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;

  void append(const Pairs& more) {
    const Eigen::Index before = values.size();
    values.conservativeResize(before + more.values.size());
    values.tail(more.values.size()) = more.values;
    vectors.conservativeResize(more.vectors.rows(), before + more.values.size());
    vectors.rightCols(more.values.size()) = more.vectors;
  }

  void sort() {
    std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    std::ranges::stable_sort(order, [this](Eigen::Index a, Eigen::Index b) { return values[a] < values[b]; });
    values = Eigen::VectorXd(values(order));
    vectors = Eigen::MatrixXd(vectors(Eigen::all, order));
  }

  Eigen::Index count_below(double limit) const { return (values.array() < limit).count(); }
};

/// Numbers without structure, the same on every machine: no mode of a symmetric tree is orthogonal to them.
Eigen::VectorXd start_vector(Eigen::Index size) {
  Eigen::VectorXd start(size);
  std::uint64_t state = 0x9E3779B97F4A7C15;
  for (Eigen::Index i = 0; i < size; ++i) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    start[i] = static_cast<double>(state >> 11U) * 0x1p-53 - 0.5;
  }
  return start;
}

Result<Pairs> lanczos(InverseStiffness& inverse, const SparseMatrix& mass, Eigen::Index count) {
  const Eigen::Index size = mass.rows();
  // Most of the time goes into keeping the basis orthogonal: small, with more restarts, is faster than the usual twice the
  // count.
  const Eigen::Index basis = std::min(size, count + std::max<Eigen::Index>(20, count / 2));
  Spectra::SparseSymMatProd<double> mass_product(mass);
  Spectra::SymGEigsShiftSolver<InverseStiffness, Spectra::SparseSymMatProd<double>, Spectra::GEigsMode::ShiftInvert> solver(
      inverse, mass_product, count, basis, 0.0);
  solver.init(start_vector(size).data());
  solver.compute(Spectra::SortRule::LargestMagn, kMaximumRestarts, kRestartTolerance, Spectra::SortRule::SmallestAlge);
  if (solver.info() != Spectra::CompInfo::Successful) {
    return Error{ErrorCode::unsupported, fmt::format("the search for {} modes did not converge: ask for fewer", count)};
  }
  return Pairs{solver.eigenvalues(), solver.eigenvectors()};
}

Pairs all_modes(const BeamStructure& structure) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(Eigen::MatrixXd(structure.stiffness),
                                                                         Eigen::MatrixXd(structure.mass));
  return {solver.eigenvalues(), solver.eigenvectors()};
}

/// How many modes lie below w^2 = limit (Sylvester's law of inertia).
Eigen::Index count_modes_below(const BeamStructure& structure, double limit) {
  const Factorisation shifted(structure.stiffness - limit * structure.mass);
  return (shifted.vectorD().array() < 0).count();
}

/// Names the node that nothing holds, when K has no inverse.
Result<void> check_held(const BeamStructure& structure, const Factorisation& factorisation) {
  const Eigen::VectorXd pivots = factorisation.vectorD();  // valid up to the first that is zero
  const Eigen::VectorXd diagonal = structure.stiffness.diagonal();
  for (Eigen::Index i = 0; i < diagonal.size(); ++i) {
    // A pivot is what holds a degree of freedom once everything beyond it is free; nothing leaves the rounding of the diagonal.
    if (pivots[i] > 1e-13 * diagonal[i]) continue;
    const auto node = structure.node_count - 1 - static_cast<std::size_t>(i / BeamStructure::kDofPerNode);
    return Error{ErrorCode::invalid_argument,
                 fmt::format("node {} is not held, or by something 1e13 times weaker than what it holds: the "
                             "stiffness matrix is singular; give the wood below that node some thickness",
                             node)};
  }
  return {};
}

/// Modes of one frequency are any turn of each other. Of those turns, the one that keeps motion in x, y and z apart.
void separate(Eigen::Ref<Eigen::MatrixXd> same, const Eigen::VectorXd& point_mass) {
  Eigen::MatrixXd preference = Eigen::MatrixXd::Zero(same.cols(), same.cols());
  for (Eigen::Index row = 0; row < same.rows(); row += BeamStructure::kDofPerNode) {
    const double mass = point_mass[row / BeamStructure::kDofPerNode];
    preference.noalias() -= 2 * mass * same.row(row).transpose() * same.row(row);
    preference.noalias() -= mass * same.row(row + 1).transpose() * same.row(row + 1);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(preference);  // ascending: most motion in x first
  same = Eigen::MatrixXd(same * solver.eigenvectors());
}

void separate_modes_of_one_frequency(Pairs& pairs, const BeamStructure& structure) {
  const Eigen::VectorXd diagonal = structure.mass.diagonal();
  const Eigen::Index nodes = diagonal.size() / BeamStructure::kDofPerNode;
  const Eigen::VectorXd point_mass = diagonal(Eigen::seqN(0, nodes, BeamStructure::kDofPerNode));
  Eigen::Index begin = 0;
  while (begin < pairs.values.size()) {
    Eigen::Index end = begin + 1;
    while (end < pairs.values.size() && pairs.values[end] - pairs.values[end - 1] < kSameFrequency * pairs.values[end]) ++end;
    if (end - begin > 1) separate(pairs.vectors.middleCols(begin, end - begin), point_mass);
    begin = end;
  }
}

/// Mass-normalised, the largest displacement positive; of several as large (a symmetric tree), the one nearest the foot.
void normalise(Eigen::Ref<Eigen::VectorXd> shape, const SparseMatrix& mass) {
  shape /= std::sqrt(shape.dot(mass * shape));
  double largest = 0;
  double sign = 1;
  for (Eigen::Index node = shape.size() / BeamStructure::kDofPerNode - 1; node >= 0; --node) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double value = shape[node * BeamStructure::kDofPerNode + axis];
      if (std::abs(value) <= (1 + 1e-6) * largest) continue;
      largest = std::abs(value);
      sign = value < 0 ? -1 : 1;
    }
  }
  shape *= sign;
}

Result<Pairs> iterate(const BeamStructure& structure, const Factorisation& factorisation, Eigen::Index count) {
  const Eigen::Index size = structure.dof_count();
  InverseStiffness inverse(factorisation, structure.mass);
  // Two beyond: a pair of one frequency is then found whole.
  auto pairs = lanczos(inverse, structure.mass, std::min(count + 2, size - 1));
  if (!pairs) return pairs.error();
  for (int search = 0; search < kMaximumSearches; ++search) {
    pairs->sort();
    const double limit = pairs->values[count - 1] * (1 + kSameFrequency);
    const Eigen::Index missing = count_modes_below(structure, limit) - pairs->count_below(limit);
    if (missing <= 0) return pairs;
    inverse.leave_out(pairs->vectors);
    auto more = lanczos(inverse, structure.mass, std::min(missing, size - pairs->values.size() - 1));
    if (!more) return more.error();
    pairs->append(*more);
  }
  return Error{ErrorCode::unsupported, "modes of one frequency could not be told apart: ask for fewer modes"};
}

void measure_residuals(Modes& modes, const BeamStructure& structure, const Factorisation& factorisation) {
  const SparseMatrix magnitude = structure.stiffness.cwiseAbs();
  for (Eigen::Index i = 0; i < modes.shapes.cols(); ++i) {
    const Eigen::VectorXd inertia = modes.stiffness_per_s2[i] * (structure.mass * modes.shapes.col(i));
    const Eigen::VectorXd left = modes.shapes.col(i) - factorisation.solve(inertia);
    modes.largest_residual = std::max(modes.largest_residual, std::sqrt(left.dot(structure.mass * left)));
    const Eigen::VectorXd imbalance = structure.stiffness * modes.shapes.col(i) - inertia;
    const Eigen::VectorXd terms = magnitude * modes.shapes.col(i).cwiseAbs();
    modes.largest_imbalance = std::max(modes.largest_imbalance, imbalance.norm() / terms.norm());
  }
}

Result<void> check_size(const BeamStructure& structure, const ModeOptions& options) {
  const auto size = static_cast<std::size_t>(structure.dof_count());
  const std::size_t most = structure.dof_count() <= kDenseSize ? size : size - 1;
  if (options.mode_count == 0) return Error{ErrorCode::invalid_argument, "at least one mode must be asked for"};
  if (options.mode_count > most) {
    return Error{ErrorCode::invalid_argument, fmt::format("{} modes asked for, but {} nodes that can move give at most {}",
                                                          options.mode_count, structure.node_count - 1, most)};
  }
  const double needed = modal_analysis_bytes(structure.node_count, options.mode_count);
  if (needed > options.memory_limit_bytes) {
    return Error{ErrorCode::invalid_argument,
                 fmt::format("{} modes of {} nodes need {:.1f} GB, above the limit of {:.1f} GB: ask for fewer modes, or leave "
                             "thin branches out",
                             options.mode_count, structure.node_count, needed / 1e9, options.memory_limit_bytes / 1e9)};
  }
  return {};
}

}  // namespace

double modal_analysis_bytes(std::size_t node_count, std::size_t mode_count) {
  const auto nodes = static_cast<double>(node_count);
  const auto modes = static_cast<double>(mode_count);
  constexpr double kAssembly = 2 * 144 * 16;  // triplets of both matrices, 144 entries of an element each
  constexpr double kMatrices = 5 * 108 * 12;  // K, M, |K|, K - sM and the factor: 36 on the diagonal, 36 on each side
  const double vectors = 6 * 8 * (2 * modes + 20 + 3 * modes);  // Lanczos' basis, its modes and what is made of them
  return nodes * (kAssembly + kMatrices + vectors);
}

Result<Modes> first_modes(const BeamStructure& structure, const ModeOptions& options) {
  if (auto checked = check_size(structure, options); !checked) return checked.error();
  const Factorisation factorisation(structure.stiffness);
  if (auto held = check_held(structure, factorisation); !held) return held.error();

  const auto count = static_cast<Eigen::Index>(options.mode_count);
  auto pairs =
      structure.dof_count() <= kDenseSize ? Result<Pairs>(all_modes(structure)) : iterate(structure, factorisation, count);
  if (!pairs) return pairs.error();
  separate_modes_of_one_frequency(*pairs, structure);

  Modes modes{.stiffness_per_s2 = pairs->values.head(count), .shapes = pairs->vectors.leftCols(count)};
  for (Eigen::Index i = 0; i < count; ++i) normalise(modes.shapes.col(i), structure.mass);
  measure_residuals(modes, structure, factorisation);
  if (!(modes.largest_residual < kAcceptedResidual)) {
    return Error{
        ErrorCode::unsupported,
        fmt::format("the modes hold to {:.1e} only, {:.0e} is asked for: very short thick pieces beside long thin ones; "
                    "leave the shortest out",
                    modes.largest_residual, kAcceptedResidual)};
  }
  return modes;
}

}  // namespace roseau::structure
