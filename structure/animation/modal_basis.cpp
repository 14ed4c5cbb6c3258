#include "structure/animation/modal_basis.h"

#include <fmt/format.h>

namespace roseau::structure {

namespace {

Error invalid(std::string message) { return {ErrorCode::invalid_argument, "modal basis: " + std::move(message)}; }

}  // namespace

Result<void> check(const ModalBasis& basis) {
  const auto modes = basis.shapes.cols();
  if (modes == 0) return invalid("it has no mode; ask for at least one");
  if (basis.shapes.rows() == 0) return invalid("it has no node");
  if (basis.shapes.rows() % 3 != 0) {
    return invalid(fmt::format("the shapes have {} rows, which is not three per node", basis.shapes.rows()));
  }
  const auto fits = [&](auto count, const char* what) -> Result<void> {
    if (count == modes) return {};
    return invalid(fmt::format("{} modes have shapes, but {} have a {}", modes, count, what));
  };
  if (auto fit = fits(basis.natural_frequency_hz.size(), "natural frequency"); !fit) return fit;
  if (auto fit = fits(basis.damping_coefficient_per_s.size(), "damping coefficient"); !fit) return fit;
  if (auto fit = fits(basis.wind_projection.cols(), "wind projection"); !fit) return fit;
  if (!basis.shapes.allFinite() || !basis.wind_projection.allFinite()) {
    return invalid("a shape or a wind projection is not a finite number");
  }
  for (Eigen::Index i = 0; i < modes; ++i) {
    const double frequency_hz = basis.natural_frequency_hz[i];
    const double gamma_per_s = basis.damping_coefficient_per_s[i];
    if (!(frequency_hz > 0) || !std::isfinite(frequency_hz)) {
      return invalid(fmt::format("the natural frequency of mode {} is {} Hz; it must be positive", i, frequency_hz));
    }
    if (!(gamma_per_s >= 0) || !std::isfinite(gamma_per_s)) {
      return invalid(fmt::format("the damping coefficient of mode {} is {} 1/s; it must be zero or more", i, gamma_per_s));
    }
  }
  return {};
}

}  // namespace roseau::structure
