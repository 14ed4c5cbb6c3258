#include "synthesis/wind/coherent_spectra.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/check.h"
#include "core/random.h"

namespace roseau::synthesis {

namespace {
constexpr double kGridRatio = 1.03;
constexpr double kNothingShared = 9;  // exponent: a coherence of 1e-4
// Rounding alone may make the matrix of strands a few millimetres apart indefinite.
constexpr double kJitter = 1e-9;

using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Real and imaginary part with standard deviation 1: both numbers of a Box-Muller pair.
std::complex<float> normal_pair(const RandomStream& random, std::uint64_t index) {
  const double radius = std::sqrt(-2 * std::log(random.uniform(2 * index)));
  const double angle = 2 * std::numbers::pi * random.uniform(2 * index + 1);
  return {static_cast<float>(radius * std::cos(angle)), static_cast<float>(radius * std::sin(angle))};
}

Eigen::MatrixXd separations_s(std::span<const Vec2> places, const DavenportCoherence& coherence) {
  const auto n = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixXd separations(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const Vec2& a = places[static_cast<std::size_t>(i)];
      const Vec2& b = places[static_cast<std::size_t>(j)];
      separations(i, j) = coherence.separation_s(a.x - b.x, a.y - b.y);
    }
  }
  return separations;
}

double least_separation_s(const Eigen::MatrixXd& separations) {
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < separations.rows(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j) least = std::min(least, separations(i, j));
  }
  return least;
}

// Lower triangular, rows of norm 1, so that rounding changes no strand's power.
Eigen::MatrixXf coherence_factor(const Eigen::MatrixXd& separations, double rate_hz) {
  Eigen::MatrixXd matrix = (-rate_hz * separations.array()).exp().matrix();
  matrix.diagonal().array() += kJitter;
  const Eigen::LLT<Eigen::MatrixXd> cholesky(matrix);
  ROSEAU_CHECK(cholesky.info() == Eigen::Success);
  Eigen::MatrixXd factor = cholesky.matrixL();
  for (Eigen::Index i = 0; i < factor.rows(); ++i) factor.row(i).normalize();
  return factor.cast<float>();
}
}  // namespace

std::vector<std::complex<float>> coherent_amplitudes(std::span<const Vec2> places, const DavenportCoherence& coherence,
                                                     std::span<const float> amplitude, double period_s, std::uint64_t seed) {
  const std::size_t harmonics = amplitude.size();
  std::vector<std::complex<float>> all(places.size() * harmonics);
  std::vector<RandomStream> streams;
  for (std::size_t i = 0; i < places.size(); ++i) streams.emplace_back(seed, i);
  const Eigen::MatrixXd separations = separations_s(places, coherence);
  const double least_s = least_separation_s(separations);

  Rows fresh;
  for (std::size_t first = 0; first < harmonics;) {
    // As many harmonics as differ by the grid's ratio, in the quantity that coherence depends on.
    const double rate_hz = coherence.rate_hz(static_cast<double>(first + 1) / period_s);
    std::size_t end = first + 1;
    while (end < harmonics && coherence.rate_hz(static_cast<double>(end + 1) / period_s) < kGridRatio * rate_hz) ++end;
    const double middle_hz = coherence.rate_hz(static_cast<double>(first + end + 1) / (2 * period_s));

    fresh.resize(static_cast<Eigen::Index>(places.size()), static_cast<Eigen::Index>(2 * (end - first)));
    for (std::size_t i = 0; i < places.size(); ++i) {
      float* row = fresh.row(static_cast<Eigen::Index>(i)).data();
      for (std::size_t k = first; k < end; ++k) {
        const std::complex<float> normal = normal_pair(streams[i], k);
        *row++ = normal.real() * amplitude[k];
        *row++ = normal.imag() * amplitude[k];
      }
    }
    if (middle_hz * least_s < kNothingShared) {
      const Eigen::MatrixXf factor = coherence_factor(separations, middle_hz);
      fresh = Rows(factor.triangularView<Eigen::Lower>() * fresh);
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      const float* row = fresh.row(static_cast<Eigen::Index>(i)).data();
      for (std::size_t k = first; k < end; ++k, row += 2) all[i * harmonics + k] = {row[0], row[1]};
    }
    first = end;
  }
  return all;
}

std::vector<std::complex<float>> lost_amplitudes(double separation_s, const DavenportCoherence& coherence,
                                                 std::span<const float> amplitude, double period_s, std::uint64_t seed,
                                                 std::uint64_t row) {
  const RandomStream random(seed, row);
  std::vector<std::complex<float>> lost(amplitude.size());
  for (std::size_t k = 0; k < lost.size(); ++k) {
    const double rate_hz = coherence.rate_hz(static_cast<double>(k + 1) / period_s);
    const double share = std::sqrt(-std::expm1(-rate_hz * separation_s));
    lost[k] = normal_pair(random, k) * (amplitude[k] * static_cast<float>(share));
  }
  return lost;
}

}  // namespace roseau::synthesis
