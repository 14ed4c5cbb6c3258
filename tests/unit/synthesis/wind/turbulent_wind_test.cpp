#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>
#include <vector>

#include "synthesis/wind/spectrum.h"
#include "synthesis/wind/turbulent_wind.h"

namespace roseau::synthesis {
namespace {

constexpr double kRateHz = 32;
constexpr auto kSamples = static_cast<std::size_t>(kRateHz * TurbulentWind::kPeriodS);

const Vec3 kHere{0, 0, 2.6};

struct Series {
  std::vector<double> along, across, up;
};

// One whole period at one point, so that its discrete transform has no leakage. Mean wind from the west.
Series series_at(const TurbulentWind& wind, const Vec3& point) {
  Series series;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const Vec3 velocity = wind.velocity_mps(point, static_cast<double>(i) / kRateHz);
    series.along.push_back(velocity.x);
    series.across.push_back(velocity.y);
    series.up.push_back(velocity.z);
  }
  return series;
}

std::vector<std::complex<double>> lines_of(const std::vector<double>& series) {
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> lines;
  fft.fwd(lines, series);
  return lines;
}

double sd_of(const std::vector<double>& series) {
  double sum = 0;
  double sum2 = 0;
  for (const double value : series) {
    sum += value;
    sum2 += value * value;
  }
  const auto n = static_cast<double>(series.size());
  return std::sqrt(sum2 / n - sum * sum / (n * n));
}

template <class Spectrum>
void expect_spectrum(const std::vector<double>& series, const Spectrum& target) {
  const auto lines = lines_of(series);
  for (double low_hz = 1.0 / 128; low_hz < 6; low_hz *= 2) {
    const auto first = static_cast<std::size_t>(low_hz * TurbulentWind::kPeriodS);
    double measured = 0;
    double wanted = 0;
    for (std::size_t k = first; k < 2 * first; ++k) {
      measured += 2 * std::norm(lines[k]) / (static_cast<double>(kSamples) * static_cast<double>(kSamples));
      wanted += target(static_cast<double>(k) / TurbulentWind::kPeriodS) / TurbulentWind::kPeriodS;
    }
    // Each line is exponentially distributed; 4 standard deviations of the band's mean, and what interpolation takes away.
    EXPECT_NEAR(measured / wanted, 1, 4 / std::sqrt(static_cast<double>(first)) + 0.02) << "from " << low_hz << " Hz";
  }
}

TEST(TurbulentWind, HasTheStatedSpectraAndSpreads) {
  const TurbulentWindOptions options;  // from the west: along = east, across (left of it) = north
  const TurbulentWind wind(options, 7, std::vector{kHere});
  const Series series = series_at(wind, kHere);
  const double sd = options.turbulence_intensity * options.mean_speed_mps;

  expect_spectrum(series.along, [&](double f) { return von_karman_along(f, 4, sd, 30); });
  expect_spectrum(series.across, [&](double f) { return von_karman_across(f, 4, 0.8 * sd, 15); });
  expect_spectrum(series.up, [&](double f) { return von_karman_across(f, 4, 0.5 * sd, 15); });

  // A period holds about 270 independent gusts: 4.3 % standard deviation of a spread; and 16 Hz and up (2 %) is cut off.
  EXPECT_NEAR(sd_of(series.along) / sd, 1, 0.15);
  EXPECT_NEAR(sd_of(series.across) / (0.8 * sd), 1, 0.15);
  EXPECT_NEAR(sd_of(series.up) / (0.5 * sd), 1, 0.15);
}

TEST(TurbulentWind, VonKarmanSpectraIntegrateToTheVariance) {
  for (const auto spectrum : {von_karman_along, von_karman_across}) {
    double variance = 0;
    for (double log_f = std::log(1e-6); log_f < std::log(1e5); log_f += 1e-3) {
      const double f = std::exp(log_f);
      variance += spectrum(f, 5, 1.5, 40) * f * 1e-3;
    }
    EXPECT_NEAR(variance, 1.5 * 1.5, 0.01);
  }
}

TEST(TurbulentWind, DriftsWithTheMeanWindUnchanged) {
  const TurbulentWind wind(TurbulentWindOptions{.direction_from_deg = 215}, 3, std::vector{kHere});
  const Vec3 along = wind.along();
  for (const double time_s : {0.0, 17.3, 4000.1}) {
    const Vec3 here = wind.velocity_mps(kHere, time_s);
    const double later_s = 2.5;
    const Vec3 downwind{kHere.x + 4 * later_s * along.x, kHere.y + 4 * later_s * along.y, kHere.z};
    const Vec3 there = wind.velocity_mps(downwind, time_s + later_s);
    EXPECT_NEAR(here.x, there.x, 1e-5);
    EXPECT_NEAR(here.y, there.y, 1e-5);
    EXPECT_NEAR(here.z, there.z, 1e-5);
  }
}

TEST(TurbulentWind, IsPeriodicAndDefinedBeforeItsStart) {
  const TurbulentWind wind({}, 3, std::vector{kHere});
  for (const double time_s : {-5000.0, -0.01, 1.23}) {
    EXPECT_NEAR(wind.velocity_mps(kHere, time_s).x, wind.velocity_mps(kHere, time_s + TurbulentWind::kPeriodS).x, 1e-9);
  }
}

TEST(TurbulentWind, DirectionIsWhereItComesFrom) {
  const auto calm_air = [](double direction_deg) {
    const TurbulentWind wind({.mean_speed_mps = 4, .direction_from_deg = direction_deg, .turbulence_intensity = 0}, 1,
                             std::vector{kHere});
    return wind.velocity_mps(kHere, 1);
  };
  EXPECT_NEAR(calm_air(270).x, 4, 1e-12);  // from the west: towards the east
  EXPECT_NEAR(calm_air(0).y, -4, 1e-12);   // from the north: towards the south
  EXPECT_NEAR(calm_air(90).x, -4, 1e-12);  // from the east
  EXPECT_NEAR(calm_air(270).y, 0, 1e-12);
}

TEST(TurbulentWind, MeanFollowsThePowerLawInHeight) {
  const TurbulentWind wind({.turbulence_intensity = 0, .reference_height_m = 10, .profile_exponent = 0.2}, 1,
                           std::vector{kHere});
  EXPECT_NEAR(wind.velocity_mps({0, 0, 10}, 0).x, 4, 1e-12);
  EXPECT_NEAR(wind.velocity_mps({0, 0, 2}, 0).x, 4 * std::pow(0.2, 0.2), 1e-12);
  EXPECT_GT(wind.velocity_mps({0, 0, -1}, 0).x, 0);  // below ground: still a number
}

// Magnitude of the coherence between two points across the wind, averaged over [low, high).
double coherence(const Series& a, const Series& b, double low_hz, double high_hz) {
  const auto lines_a = lines_of(a.along);
  const auto lines_b = lines_of(b.along);
  std::complex<double> cross;
  double power_a = 0;
  double power_b = 0;
  const auto line_at = [](double frequency_hz) { return static_cast<std::size_t>(frequency_hz * TurbulentWind::kPeriodS); };
  for (std::size_t k = line_at(low_hz); k < line_at(high_hz); ++k) {
    cross += lines_a[k] * std::conj(lines_b[k]);
    power_a += std::norm(lines_a[k]);
    power_b += std::norm(lines_b[k]);
  }
  return std::abs(cross) / std::sqrt(power_a * power_b);
}

TEST(TurbulentWind, LosesCoherenceAcrossTheWindWithDistanceAndFrequency) {
  const std::vector<Vec3> points{{0, 0, 2.6}, {0, 1, 2.6}, {0, 3, 2.6}};
  const TurbulentWind wind({}, 11, points);
  const std::vector<Series> series{series_at(wind, points[0]), series_at(wind, points[1]), series_at(wind, points[2])};
  const auto davenport = [](double f, double distance_m) {
    return std::exp(-10 * std::hypot(f, 0.1 * 4 / 30) * distance_m / 4);
  };
  EXPECT_NEAR(coherence(series[0], series[1], 0.08, 0.12), davenport(0.1, 1), 0.08);
  EXPECT_NEAR(coherence(series[0], series[1], 0.28, 0.32), davenport(0.3, 1), 0.15);
  EXPECT_NEAR(coherence(series[0], series[2], 0.08, 0.12), davenport(0.1, 3), 0.15);
  EXPECT_LT(coherence(series[0], series[2], 1, 2), 0.1);
}

TEST(TurbulentWind, SeedDecidesTheField) {
  const TurbulentWind one({}, 1, std::vector{kHere});
  const TurbulentWind same({}, 1, std::vector{kHere});
  const TurbulentWind other({}, 2, std::vector{kHere});
  EXPECT_EQ(one.velocity_mps(kHere, 5.5).x, same.velocity_mps(kHere, 5.5).x);
  EXPECT_NE(one.velocity_mps(kHere, 5.5).x, other.velocity_mps(kHere, 5.5).x);
}

}  // namespace
}  // namespace roseau::synthesis
