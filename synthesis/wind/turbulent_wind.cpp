#include "synthesis/wind/turbulent_wind.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "core/check.h"
#include "synthesis/random.h"
#include "synthesis/wind/spectrum.h"

namespace roseau::synthesis {

namespace {
// 64 Hz: cubic interpolation then keeps 98 % of the amplitude at 10 Hz, the fastest a 20 Hz sonic can show.
constexpr std::size_t kTableSize = std::size_t{1} << 18U;
constexpr double kTableRateHz = static_cast<double>(kTableSize) / TurbulentWind::kPeriodS;
constexpr double kHighestFrequencyHz = 16;
constexpr double kSameStrandM = 1e-3;
constexpr double kLowestHeightM = 0.1;  // the power law has no meaning at the ground

Vec3 along_from_direction(double direction_from_deg) {
  const double from_rad = direction_from_deg * std::numbers::pi / 180;
  return {-std::sin(from_rad), -std::cos(from_rad), 0};
}
}  // namespace

TurbulentWind::TurbulentWind(const TurbulentWindOptions& options, std::uint64_t seed, std::span<const Vec3> points_in_world)
    : options_(options), along_(along_from_direction(options.direction_from_deg)) {
  ROSEAU_CHECK(options.mean_speed_mps > 0 && !points_in_world.empty());
  std::vector<double> laterals;
  for (const Vec3& point : points_in_world) laterals.push_back(lateral_m(point));
  std::ranges::sort(laterals);
  for (const double lateral : laterals) {
    if (!strands_.empty() && lateral - strands_.back().lateral_m < kSameStrandM) continue;
    strands_.push_back({lateral, std::vector<Gust>(kTableSize)});
  }
  make_component(&Gust::along, scatter_bits(seed));
  make_component(&Gust::across, scatter_bits(seed + 1));
  make_component(&Gust::up, scatter_bits(seed + 2));
}

// Each harmonic of the period has a Gaussian complex amplitude. Over the strands, in lateral order, it is a first-order
// Markov chain: that has exactly the exponential coherence wanted between any two strands, at one new number per strand.
void TurbulentWind::make_component(float Gust::*component, std::uint64_t seed) {
  const bool is_along = component == &Gust::along;
  const double ratio = is_along ? 1 : component == &Gust::across ? options_.across_sd_ratio : options_.vertical_sd_ratio;
  const double sd_mps = options_.turbulence_intensity * options_.mean_speed_mps * ratio;
  const double length_m = is_along ? options_.length_scale_m : options_.across_length_scale_m;
  const auto spectrum = is_along ? von_karman_along : von_karman_across;
  const double slowest_hz = 0.1 * options_.mean_speed_mps / length_m;

  const auto harmonics = static_cast<std::size_t>(kHighestFrequencyHz * kPeriodS);
  std::vector<std::complex<double>> chain(harmonics + 1);
  std::vector<std::complex<double>> half_spectrum(kTableSize / 2 + 1);
  std::vector<double> series(kTableSize);
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);

  for (std::size_t j = 0; j < strands_.size(); ++j) {
    const RandomStream random(seed, j);
    const double distance_m = j == 0 ? 0 : strands_[j].lateral_m - strands_[j - 1].lateral_m;
    for (std::size_t k = 1; k <= harmonics; ++k) {
      const double frequency_hz = static_cast<double>(k) / kPeriodS;
      const std::complex<double> fresh(random.normal(2 * k), random.normal(2 * k + 1));
      const double decay_per_m = options_.lateral_decay * std::hypot(frequency_hz, slowest_hz) / options_.mean_speed_mps;
      const double coherence = j == 0 ? 0 : std::exp(-decay_per_m * distance_m);
      chain[k] = coherence * chain[k] + std::sqrt(1 - coherence * coherence) * fresh;
      const double power = spectrum(frequency_hz, options_.mean_speed_mps, sd_mps, length_m) / kPeriodS;
      // a cos + b sin with variances `power` each; the inverse transform divides by the size.
      half_spectrum[k] = chain[k] * std::sqrt(power) * (0.5 * static_cast<double>(kTableSize));
    }
    fft.inv(series, half_spectrum, static_cast<Eigen::Index>(kTableSize));
    for (std::size_t i = 0; i < kTableSize; ++i) strands_[j].gusts[i].*component = static_cast<float>(series[i]);
  }
}

// Catmull-Rom through the four nearest table entries.
Vec3 TurbulentWind::gust_at(const Strand& strand, double table_position) {
  const double whole = std::floor(table_position);
  const double s = table_position - whole;
  const auto first = static_cast<std::size_t>(static_cast<std::int64_t>(whole) - 1);
  const double weights[4] = {s * (-0.5 + s * (1 - 0.5 * s)), 1 + s * s * (-2.5 + 1.5 * s), s * (0.5 + s * (2 - 1.5 * s)),
                             s * s * (-0.5 + 0.5 * s)};
  Vec3 gust;
  for (std::size_t i = 0; i < 4; ++i) {
    const Gust& entry = strand.gusts[(first + i) % kTableSize];
    gust.x += weights[i] * static_cast<double>(entry.along);
    gust.y += weights[i] * static_cast<double>(entry.across);
    gust.z += weights[i] * static_cast<double>(entry.up);
  }
  return gust;
}

Vec3 TurbulentWind::velocity_mps(const Vec3& point_in_world, double time_s) const {
  const double along_m = point_in_world.x * along_.x + point_in_world.y * along_.y;
  const double table_position = std::fmod(time_s - along_m / options_.mean_speed_mps, kPeriodS) * kTableRateHz;

  const double lateral = lateral_m(point_in_world);
  const auto right = std::ranges::upper_bound(strands_, lateral, {}, &Strand::lateral_m);
  Vec3 gust;
  if (right == strands_.begin()) {
    gust = gust_at(strands_.front(), table_position);
  } else if (right == strands_.end()) {
    gust = gust_at(strands_.back(), table_position);
  } else {
    const Strand& left = *std::prev(right);
    const double share = (lateral - left.lateral_m) / (right->lateral_m - left.lateral_m);
    gust = gust_at(left, table_position);
    if (share > 1e-6) {
      const Vec3 other = gust_at(*right, table_position);
      gust = {gust.x + share * (other.x - gust.x), gust.y + share * (other.y - gust.y), gust.z + share * (other.z - gust.z)};
    }
  }

  const double height_m = std::max(point_in_world.z, kLowestHeightM);
  const double mean_mps =
      options_.profile_exponent == 0
          ? options_.mean_speed_mps
          : options_.mean_speed_mps * std::pow(height_m / options_.reference_height_m, options_.profile_exponent);
  const double along_mps = mean_mps + gust.x;
  return {along_mps * along_.x - gust.y * along_.y, along_mps * along_.y + gust.y * along_.x, gust.z};
}

}  // namespace roseau::synthesis
