#include "synthesis/wind/mean_wind.h"

#include <bit>
#include <cmath>
#include <numbers>

#include "core/check.h"

namespace roseau::synthesis {

namespace {
constexpr double kLowestPowerHeightM = 0.1;
constexpr double kHighestM = 1024;

// 256 equal steps per octave of height: a height's upper bits number its step, and no logarithm is needed to find it.
constexpr unsigned kStepBits = 8;
constexpr unsigned kShift = 52 - kStepBits;
constexpr std::uint64_t kBelowStep = (std::uint64_t{1} << kShift) - 1;
constexpr double kPerStep = 1.0 / static_cast<double>(kBelowStep + 1);

std::uint64_t step_of(double height_m) { return std::bit_cast<std::uint64_t>(height_m) >> kShift; }
double height_of(std::uint64_t step) { return std::bit_cast<double>(step << kShift); }
}  // namespace

Vec3 towards_from_direction(double direction_from_deg) {
  const double from_rad = direction_from_deg * std::numbers::pi / 180;
  return {-std::sin(from_rad), -std::cos(from_rad), 0};
}

MeanProfile::MeanProfile(const MeanProfileOptions& options) : options_(options) {
  ROSEAU_CHECK(options.reference_height_m > 0 && options.exponent >= 0);
  if (options.shape == ProfileShape::uniform) return;
  const bool is_logarithmic = options.shape == ProfileShape::logarithmic;
  ROSEAU_CHECK(!is_logarithmic || (options.roughness_length_m > 0 &&
                                   options.reference_height_m > options.displacement_height_m + options.roughness_length_m));
  lowest_m_ = is_logarithmic ? options.roughness_length_m : kLowestPowerHeightM;
  first_key_ = step_of(lowest_m_);
  for (std::uint64_t step = first_key_; step <= step_of(kHighestM) + 1; ++step) table_.push_back(formula(height_of(step)));
}

double MeanProfile::formula(double height_m) const {
  if (options_.shape == ProfileShape::power) return std::pow(height_m / options_.reference_height_m, options_.exponent);
  const double reference_m = options_.reference_height_m - options_.displacement_height_m;
  return std::log(height_m / options_.roughness_length_m) / std::log(reference_m / options_.roughness_length_m);
}

double MeanProfile::ratio(double height_m) const {
  if (table_.empty()) return 1;
  const bool is_logarithmic = options_.shape == ProfileShape::logarithmic;
  const double above_m = is_logarithmic ? height_m - options_.displacement_height_m : height_m;
  if (is_logarithmic && above_m <= lowest_m_) return 0;
  const double h = above_m > kHighestM ? kHighestM : above_m > lowest_m_ ? above_m : lowest_m_;
  const std::uint64_t step = step_of(h);
  const double share = static_cast<double>(std::bit_cast<std::uint64_t>(h) & kBelowStep) * kPerStep;
  const double* entry = &table_[step - first_key_];
  return entry[0] + share * (entry[1] - entry[0]);
}

}  // namespace roseau::synthesis
