#include "synthesis/wind/turbulent_wind.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "tests/support/wind_series.h"

namespace roseau::synthesis {
namespace {

constexpr double kRateHz = 32;
constexpr double kPeriodS = 2048;
constexpr double kShortS = 64;  // where statistics do not matter
const Vec3 kHere{0, 0, 2.6};

std::size_t line_at(double frequency_hz) { return static_cast<std::size_t>(std::lround(frequency_hz * kPeriodS)); }

// Band by band, an octave each: mean over all the series, that are independent or nearly so.
template <class Target>
void expect_spectrum(const std::vector<std::vector<double>>& all, const Target& target) {
  std::vector<std::vector<std::complex<double>>> lines;
  for (const auto& series : all) lines.push_back(lines_of(series));
  for (double low_hz = 1.0 / 128; low_hz < 6; low_hz *= 2) {
    const std::size_t first = line_at(low_hz);
    double measured = 0;
    double wanted = 0;
    for (std::size_t k = first; k < 2 * first; ++k) {
      for (const auto& one : lines) measured += 2 * std::norm(one[k]) / static_cast<double>(lines.size());
      wanted += target(static_cast<double>(k) / kPeriodS) / kPeriodS;
    }
    // Each line is exponentially distributed: 4 standard deviations of the band's mean.
    const double independent = static_cast<double>(first * (low_hz < 0.2 ? 1 : lines.size()));
    EXPECT_NEAR(measured / wanted, 1, 4 / std::sqrt(independent) + 0.01) << "from " << low_hz << " Hz";
  }
}

void expect_spectra(const TurbulentWindOptions& options, const TurbulentWind& wind, std::span<const Vec3> points) {
  std::vector<std::vector<double>> along;
  std::vector<std::vector<double>> across;
  std::vector<std::vector<double>> up;
  for (Series& series : series_at(wind, points, kPeriodS, kRateHz)) {
    along.push_back(std::move(series.along));
    across.push_back(std::move(series.across));
    up.push_back(std::move(series.up));
  }
  expect_spectrum(along, [&](double f) { return gust_spectrum(options, GustTables::along, f); });
  expect_spectrum(across, [&](double f) { return gust_spectrum(options, GustTables::across, f); });
  expect_spectrum(up, [&](double f) { return gust_spectrum(options, GustTables::up, f); });
}

std::shared_ptr<const TurbulentWind> over_crown(const TurbulentWindOptions& options, std::vector<Vec3> instruments = {}) {
  const WindRegion region{.crown = WindRegion::Box{{-1.5, -1.5, 1}, {1.5, 1.5, 4}},
                          .instruments_in_world_m = std::move(instruments)};
  auto wind = TurbulentWind::make(options, 7, region);
  EXPECT_TRUE(wind) << wind.error().message;
  return *wind;
}

TEST(TurbulentWind, HasTheStatedSpectraOnAStrand) {
  for (const auto spectrum : {TurbulenceSpectrum::von_karman, TurbulenceSpectrum::kaimal}) {
    const TurbulentWindOptions options{.vertical_length_scale_m = 9, .spectrum = spectrum};
    const TurbulentWind wind(options, 7, std::vector{kHere});
    expect_spectra(options, wind, std::vector{kHere});
  }
}

// Interpolation alone would lose two fifths of the power at 1 Hz in the middle of an edge, three fifths in that of a cell.
TEST(TurbulentWind, HasTheStatedSpectraBetweenStrands) {
  const TurbulentWindOptions options;
  const auto wind = over_crown(options);
  std::vector<Vec3> inside;
  std::vector<Vec3> on_edge;
  std::vector<Vec3> off_middle;
  for (double i = 0; i < 3; ++i) {
    inside.push_back({0, -1.2 + 1.2 * i, 1.3 + 1.2 * i});
    on_edge.push_back({0, -1.2 + 1.2 * i, 1 + 1.2 * i});
    off_middle.push_back({0, -1.4 + 1.2 * i, 3.85 - 1.2 * i});
  }
  expect_spectra(options, *wind, inside);
  expect_spectra(options, *wind, on_edge);
  expect_spectra(options, *wind, off_middle);
}

TEST(TurbulentWind, HasTheStatedSpreads) {
  const TurbulentWindOptions options{.across_sd_ratio = 0.7,
                                     .vertical_sd_ratio = 0.4,
                                     .length_scale_m = 5,
                                     .across_length_scale_m = 5,
                                     .vertical_length_scale_m = 5};
  const TurbulentWind wind(options, 7, std::vector{kHere});
  const Series series = series_at(wind, std::vector{kHere}, kPeriodS, kRateHz).front();
  // 1600 independent gusts in a period: 3.5 % of a variance; and what is above 12.8 Hz (up to 4 %) is cut off.
  EXPECT_NEAR(variance_of(series.along) / 1.44, 0.99, 0.1);
  EXPECT_NEAR(variance_of(series.across) / (1.44 * 0.49), 0.97, 0.1);
  EXPECT_NEAR(variance_of(series.up) / (1.44 * 0.16), 0.97, 0.1);
}

TEST(TurbulentWind, SpectraIntegrateToTheVariance) {
  for (const auto spectrum : {von_karman_along, von_karman_across, kaimal}) {
    double variance = 0;
    for (double log_f = std::log(1e-6); log_f < std::log(1e5); log_f += 1e-3) {
      const double f = std::exp(log_f);
      variance += spectrum(f, 5, 1.5, 40) * f * 1e-3;
    }
    EXPECT_NEAR(variance, 1.5 * 1.5, 0.01);
  }
}

// In isotropic turbulence the spectrum across follows from the one along: S_v = (S_u - f dS_u/df) / 2, at half the length.
TEST(TurbulentWind, VonKarmanIsIsotropic) {
  for (const double f : {0.002, 0.05, 0.7, 6.0}) {
    const auto along = [](double hz) { return von_karman_along(hz, 5, 1.2, 30); };
    const double slope = (along(f * 1.0001) - along(f / 1.0001)) / (f * 1.0001 - f / 1.0001);
    EXPECT_NEAR(von_karman_across(f, 5, 1.2, 15) / ((along(f) - f * slope) / 2), 1, 1e-4) << f;
  }
}

// The numbers of Kaimal, Wyngaard, Izumi and Cote (1972) at 10 m in a wind of 6 m/s with u* = 0.4 m/s.
TEST(TurbulentWind, IecFormOfKaimalIsKaimalsWithHisScales) {
  const double height_m = 10;
  const double friction2 = 0.16;
  for (const double f : {0.001, 0.03, 0.5, 8.0}) {
    const double n = f * height_m / 6;
    const double along = 105 * n / std::pow(1 + 33 * n, 5.0 / 3) * friction2 / f;
    const double across = 17 * n / std::pow(1 + 9.5 * n, 5.0 / 3) * friction2 / f;
    EXPECT_NEAR(kaimal(f, 6, std::sqrt(105 * 1.5 / 33 * friction2), 5.5 * height_m) / along, 1, 1e-9);
    EXPECT_NEAR(kaimal(f, 6, std::sqrt(17 * 1.5 / 9.5 * friction2), 9.5 / 6 * height_m) / across, 1, 1e-9);
  }
}

// Mean coherence over all pairs of points that are `step` apart on a row or a column of the lattice.
double coherence_of(const std::vector<std::vector<std::complex<double>>>& lines, std::size_t columns, std::size_t right,
                    std::size_t up, double low_hz, double high_hz) {
  CoherenceMean mean;
  const std::size_t rows = lines.size() / columns;
  for (std::size_t row = 0; row + up < rows; ++row) {
    for (std::size_t column = 0; column + right < columns; ++column) {
      const std::size_t a = row * columns + column;
      mean.add(lines[a], lines[a + up * columns + right], line_at(low_hz), line_at(high_hz));
    }
  }
  return mean.value();
}

TEST(TurbulentWind, LosesCoherenceAcrossTheWindAsDavenportSays) {
  const TurbulentWindOptions options{.lateral_decay = 8, .vertical_decay = 12};
  const auto wind = over_crown(options);
  std::vector<Vec3> points;
  for (double row = 0; row < 6; ++row) {
    for (double column = 0; column < 6; ++column) points.push_back({0, -1.5 + 0.6 * column, 1 + 0.6 * row});
  }
  ASSERT_EQ(wind->strands(), points.size());
  std::vector<std::vector<std::complex<double>>> along;
  std::vector<std::vector<std::complex<double>>> up;
  for (const Series& series : series_at(*wind, points, kPeriodS, 8)) {
    along.push_back(lines_of(series.along));
    up.push_back(lines_of(series.up));
  }
  for (const double f : {0.05, 0.2, 0.5, 1.0, 3.0}) {
    for (const auto& [right, above] : {std::pair{1U, 0U}, {0U, 1U}, {3U, 0U}, {0U, 2U}, {2U, 2U}}) {
      // exp(-sqrt(f^2 + (0.1 U / L)^2) sqrt((C_y dy)^2 + (C_z dz)^2) / U), L = 30 m along and 15 m up
      const double decay_m = std::hypot(8 * 0.6 * right, 12 * 0.6 * above);
      const double wanted = std::exp(-std::hypot(f, 0.4 / 30) * decay_m / 4);
      const double wanted_up = std::exp(-std::hypot(f, 0.4 / 15) * decay_m / 4);
      // Between 40 lines at .05 Hz and 2400 at 3 Hz, times a few independent pairs.
      const double tolerance = 0.02 + 0.35 / std::sqrt(0.4 * f * kPeriodS);
      EXPECT_NEAR(coherence_of(along, 6, right, above, 0.8 * f, 1.2 * f), wanted, tolerance) << f << right << above;
      EXPECT_NEAR(coherence_of(up, 6, right, above, 0.8 * f, 1.2 * f), wanted_up, tolerance) << f << right << above;
    }
  }
}

TEST(TurbulentWind, ComponentsAreIndependent) {
  const TurbulentWind wind({}, 5, std::vector{kHere});
  const Series series = series_at(wind, std::vector{kHere}, kPeriodS, 8).front();
  double product = 0;
  for (std::size_t i = 0; i < series.up.size(); ++i) product += series.across[i] * series.up[i];
  const double correlation =
      product / static_cast<double>(series.up.size()) / std::sqrt(variance_of(series.across) * variance_of(series.up));
  EXPECT_NEAR(correlation, 0, 0.2);
}

TEST(TurbulentWind, DriftsWithTheMeanWindUnchanged) {
  const auto wind = over_crown({.direction_from_deg = 215, .profile_exponent = 0.2, .period_s = kShortS});
  const Vec3 along = wind->along();
  for (const Vec3& here : {kHere, Vec3{0.4, -0.7, 1.9}}) {
    for (const double time_s : {0.0, 17.3, 4000.1}) {
      const Vec3 first = wind->velocity_mps(here, time_s);
      const double later_s = 2.5;
      const Vec3 downwind{here.x + 4 * later_s * along.x, here.y + 4 * later_s * along.y, here.z};
      const Vec3 later = wind->velocity_mps(downwind, time_s + later_s);
      EXPECT_NEAR(first.x, later.x, 1e-5);
      EXPECT_NEAR(first.y, later.y, 1e-5);
      EXPECT_NEAR(first.z, later.z, 1e-5);
    }
  }
}

TEST(TurbulentWind, IsContinuousAcrossStrandsEdgesAndCells) {
  const auto wind = over_crown({.period_s = kShortS});
  const auto step = [&](const Vec3& a, const Vec3& b) {
    const Vec3 left = wind->velocity_mps(a, 3.21);
    const Vec3 right = wind->velocity_mps(b, 3.21);
    return std::hypot(left.x - right.x, left.y - right.y, left.z - right.z);
  };
  constexpr double kHair = 1e-7;  // the fillers rise as the root of the distance
  EXPECT_LT(step({0.3, -0.9 - kHair, 2.05}, {0.3, -0.9 + kHair, 2.05}), 5e-3);
  EXPECT_LT(step({0.3, -0.7, 2.2 - kHair}, {0.3, -0.7, 2.2 + kHair}), 5e-3);
  EXPECT_LT(step({0.3, -0.9 - kHair, 2.2 - kHair}, {0.3, -0.9 + kHair, 2.2 + kHair}), 5e-3);
  EXPECT_LT(step({0.3, 1.5 - kHair, 2.05}, {0.3, 7.5, 2.05}), 5e-3);  // outside: as at the border
  EXPECT_GT(step({0.3, -0.9, 2.05}, {0.3, -0.7, 2.05}), 5e-3);
}

TEST(TurbulentWind, ManyPointsAreEachAsOne) {
  const auto wind =
      over_crown({.direction_from_deg = 200, .profile = ProfileShape::logarithmic, .period_s = kShortS}, {{3, 1, 2.6}});
  std::vector<Vec3> points;
  for (double i = 0; i < 37; ++i) points.push_back({std::sin(i), 1.7 * std::cos(2 * i), 2.5 + 1.8 * std::sin(3 * i)});
  std::vector<Vec3> together(points.size());
  wind->velocities_mps(points, 12.3, together);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 alone = wind->velocity_mps(points[i], 12.3);
    EXPECT_EQ(alone.x, together[i].x);
    EXPECT_EQ(alone.y, together[i].y);
    EXPECT_EQ(alone.z, together[i].z);
  }
}

TEST(TurbulentWind, InstrumentsHaveStrandsOfTheirOwn) {
  for (const double direction_deg : {270.0, 222.0}) {
    const std::vector<Vec3> instruments{{1.35, 0.1, 2.6}, {-4, -3, 10}};
    const auto wind = over_crown({.direction_from_deg = direction_deg, .period_s = kShortS}, instruments);
    for (const Vec3& instrument : instruments) {
      const double lateral_m = instrument.x * wind->across().x + instrument.y * wind->across().y;
      const auto lateral = wind->lateral_axis().locate(lateral_m);
      const auto vertical = wind->vertical_axis().locate(instrument.z);
      EXPECT_NEAR(wind->lateral_axis().lines_m()[lateral.line], lateral_m, 1e-12);
      EXPECT_EQ(lateral.share, 0);
      EXPECT_NEAR(wind->vertical_axis().lines_m()[vertical.line], instrument.z, 1e-12);
      EXPECT_EQ(vertical.share, 0);
    }
    // The box, as wide as it is seen from the wind, is covered.
    const double half_width_m = 1.5 * (std::abs(wind->across().x) + std::abs(wind->across().y));
    EXPECT_LE(wind->lateral_axis().lines_m().front(), -half_width_m + 1e-9);
    EXPECT_GE(wind->lateral_axis().lines_m().back(), half_width_m - 1e-9);
  }
}

TEST(TurbulentWind, IsPeriodicAndDefinedBeforeItsStart) {
  const TurbulentWind wind({.period_s = 600}, 3, std::vector{kHere});
  EXPECT_EQ(wind.period_s(), 600);
  for (const double time_s : {-5000.0, -0.01, 1.23, 599.999}) {
    EXPECT_NEAR(wind.velocity_mps(kHere, time_s).x, wind.velocity_mps(kHere, time_s + 600).x, 1e-5);
  }
  EXPECT_NE(wind.velocity_mps(kHere, 1.23).x, wind.velocity_mps(kHere, 301.23).x);
}

TEST(TurbulentWind, APeriodThatIsSlowToMakeIsLengthenedALittle) {
  const TurbulentWind wind({.period_s = 1000.1}, 3, std::vector{kHere});
  EXPECT_GE(wind.period_s(), 1000.1);
  EXPECT_LT(wind.period_s(), 1030);
  EXPECT_NEAR(wind.velocity_mps(kHere, 5).x, wind.velocity_mps(kHere, 5 + wind.period_s()).x, 1e-5);
}

TEST(TurbulentWind, DirectionIsWhereItComesFrom) {
  const auto steady = [](double direction_deg) {
    const TurbulentWind wind({.mean_speed_mps = 4, .direction_from_deg = direction_deg, .turbulence_intensity = 0}, 1,
                             std::vector{kHere});
    EXPECT_EQ(wind.bytes(), 0U);
    return wind.velocity_mps(kHere, 1);
  };
  EXPECT_NEAR(steady(270).x, 4, 1e-12);  // from the west: towards the east
  EXPECT_NEAR(steady(0).y, -4, 1e-12);   // from the north: towards the south
  EXPECT_NEAR(steady(90).x, -4, 1e-12);  // from the east
  EXPECT_NEAR(steady(270).y, 0, 1e-12);
}

TEST(TurbulentWind, MeanFollowsTheProfileInHeight) {
  TurbulentWindOptions options{.turbulence_intensity = 0, .reference_height_m = 10, .profile_exponent = 0.2};
  const TurbulentWind power(options, 1, std::vector{kHere});
  EXPECT_NEAR(power.velocity_mps({0, 0, 10}, 0).x, 4, 1e-5);
  EXPECT_NEAR(power.velocity_mps({0, 0, 2.37}, 0).x, 4 * std::pow(0.237, 0.2), 1e-5);
  EXPECT_GT(power.velocity_mps({0, 0, -1}, 0).x, 0);  // below ground: still a number
  options.profile = ProfileShape::uniform;
  EXPECT_EQ(TurbulentWind(options, 1, std::vector{kHere}).velocity_mps({0, 0, 1}, 0).x, 4);
}

TEST(TurbulentWind, NoNumberInNoNumberOut) {
  const auto wind = over_crown({.period_s = kShortS});
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    EXPECT_TRUE(std::isnan(wind->velocity_mps({bad, 0, 2}, 0).x));
    EXPECT_TRUE(std::isnan(wind->velocity_mps({0, bad, 2}, 0).y) || std::isinf(bad));
    EXPECT_TRUE(std::isnan(wind->velocity_mps({0, 0, bad}, 0).z));
    EXPECT_TRUE(std::isnan(wind->velocity_mps({0, 0, 2}, bad).x));
  }
  wind->velocity_mps({1e300, -1e300, 2}, 1e300);  // whatever it is, it is found inside the tables
}

TEST(TurbulentWind, SeedDecidesTheField) {
  const auto here = std::vector{kHere};
  const TurbulentWind one({}, 1, here);
  const TurbulentWind same({}, 1, here);
  const TurbulentWind other({}, 2, here);
  EXPECT_EQ(one.velocity_mps(kHere, 5.5).x, same.velocity_mps(kHere, 5.5).x);
  EXPECT_NE(one.velocity_mps(kHere, 5.5).x, other.velocity_mps(kHere, 5.5).x);
}

TEST(TurbulentWind, RefusesALatticeThatIsTooLarge) {
  const auto made = [](const TurbulentWindOptions& options, const Vec3& high) {
    return TurbulentWind::make(options, 1, {.crown = WindRegion::Box{{0, 0, 0}, high}});
  };
  for (const auto& wind : {made({.strand_spacing_m = 0.01}, {5, 5, 5}), made({.strand_spacing_m = 0.6}, {5, 5, 1e5}),
                           made({.period_s = 86400}, {5, 5, 5})}) {
    ASSERT_FALSE(wind);
    EXPECT_THAT(wind.error().message, testing::HasSubstr("strand_spacing_m"));
    EXPECT_THAT(wind.error().message, testing::HasSubstr("MB"));
  }
  EXPECT_FALSE(made({}, {-1, 5, 5}));
  EXPECT_FALSE(made({}, {std::numeric_limits<double>::quiet_NaN(), 5, 5}));
  EXPECT_FALSE(TurbulentWind::make({}, 1, {}));
}

TEST(TurbulentWind, MemoryOfTheDefaultStaysWithinBounds) {
  const auto wind = TurbulentWind::make({}, 1, {.crown = WindRegion::Box{{0, 0, 1}, {0, 4.2, 5.2}}});
  ASSERT_TRUE(wind);
  EXPECT_EQ((*wind)->strands(), 64U);
  EXPECT_LT((*wind)->bytes(), 64'000'000U);
}

}  // namespace
}  // namespace roseau::synthesis
