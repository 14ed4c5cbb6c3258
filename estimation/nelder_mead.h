// Nelder and Mead's simplex search (Computer Journal 7, 1965): minimises a function of a few parameters without derivatives.
// Deterministic: the same function and start give the same bits.
#pragma once

#include <functional>
#include <span>
#include <vector>

namespace roseau::estimation {

struct SimplexOptions {
  int max_evaluations = 1000;
  double parameter_tolerance = 2e-3;  // stop when every corner is this close to the best one, in every parameter, and
  double value_tolerance = 2e-3;      // no corner's value is further than this from the best
};

struct SimplexResult {
  std::vector<double> parameters;
  double value = 0;
  int evaluations = 0;
  bool converged = false;
};

/// `steps[i]` is how far the first simplex reaches along parameter i. A function may return a huge finite value to forbid a
/// place.
SimplexResult minimise_simplex(const std::function<double(std::span<const double>)>& function, std::span<const double> start,
                               std::span<const double> steps, const SimplexOptions& options = {});

}  // namespace roseau::estimation
