#include "estimation/nelder_mead.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/check.h"

namespace roseau::estimation {

namespace {

struct Corner {
  std::vector<double> at;
  double value = 0;
};

bool has_converged(const std::vector<Corner>& simplex, const SimplexOptions& options) {
  const Corner& best = simplex.front();
  for (const Corner& corner : simplex) {
    if (std::abs(corner.value - best.value) > options.value_tolerance) return false;
    for (std::size_t i = 0; i < best.at.size(); ++i) {
      if (std::abs(corner.at[i] - best.at[i]) > options.parameter_tolerance) return false;
    }
  }
  return true;
}

std::vector<double> centroid_of_all_but_worst(const std::vector<Corner>& simplex) {
  const std::size_t dimension = simplex.front().at.size();
  std::vector<double> centroid(dimension, 0.0);
  for (std::size_t c = 0; c + 1 < simplex.size(); ++c) {
    for (std::size_t i = 0; i < dimension; ++i) centroid[i] += simplex[c].at[i];
  }
  for (double& value : centroid) value /= static_cast<double>(dimension);
  return centroid;
}

}  // namespace

SimplexResult minimise_simplex(const std::function<double(std::span<const double>)>& function, std::span<const double> start,
                               std::span<const double> steps, const SimplexOptions& options) {
  const std::size_t dimension = start.size();
  ROSEAU_CHECK(dimension > 0 && steps.size() == dimension);
  SimplexResult result;
  const auto evaluate = [&](std::vector<double> at) {
    ++result.evaluations;
    Corner corner{std::move(at), 0};
    corner.value = function(corner.at);
    return corner;
  };

  std::vector<Corner> simplex;
  simplex.push_back(evaluate({start.begin(), start.end()}));
  for (std::size_t i = 0; i < dimension; ++i) {
    std::vector<double> at(start.begin(), start.end());
    at[i] += steps[i];
    simplex.push_back(evaluate(std::move(at)));
  }
  // Stable, so that equal values keep their order and the path is reproducible.
  const auto sort = [&] { std::ranges::stable_sort(simplex, {}, &Corner::value); };
  sort();

  while (result.evaluations < options.max_evaluations) {
    if (has_converged(simplex, options)) {
      result.converged = true;
      break;
    }
    const std::vector<double> centroid = centroid_of_all_but_worst(simplex);
    Corner& worst = simplex.back();
    // factor 1: reflection; 2: expansion; 0.5: contraction outside; -0.5: contraction inside.
    const auto along = [&](double factor) {
      std::vector<double> at(dimension);
      for (std::size_t i = 0; i < dimension; ++i) at[i] = centroid[i] + factor * (centroid[i] - worst.at[i]);
      return evaluate(std::move(at));
    };

    Corner reflected = along(1);
    if (reflected.value < simplex.front().value) {
      Corner expanded = along(2);
      worst = expanded.value < reflected.value ? std::move(expanded) : std::move(reflected);
    } else if (reflected.value < simplex[dimension - 1].value) {
      worst = std::move(reflected);
    } else {
      const bool outside = reflected.value < worst.value;
      Corner contracted = along(outside ? 0.5 : -0.5);
      if (contracted.value < (outside ? reflected.value : worst.value)) {
        worst = std::move(contracted);
      } else {
        for (std::size_t c = 1; c < simplex.size(); ++c) {
          std::vector<double> at = simplex[c].at;
          for (std::size_t i = 0; i < dimension; ++i) at[i] = simplex[0].at[i] + 0.5 * (at[i] - simplex[0].at[i]);
          simplex[c] = evaluate(std::move(at));
        }
      }
    }
    sort();
  }
  result.parameters = simplex.front().at;
  result.value = simplex.front().value;
  return result;
}

}  // namespace roseau::estimation
