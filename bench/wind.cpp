// The wind of the simulated rig against its targets: spectra on strands and between them, coherence across the wind and in
// height, and what it costs.
#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "bench/bench.h"
#include "core/random.h"
#include "synthesis/wind/wind_options.h"
#include "tests/support/wind_series.h"

namespace roseau::bench {

namespace {

using synthesis::GustTables;
using synthesis::Series;
using synthesis::TurbulenceSpectrum;
using synthesis::TurbulentWind;
using synthesis::TurbulentWindOptions;

using Figures = nlohmann::ordered_json;
using Lines = std::vector<std::complex<double>>;

constexpr int kSeeds = 8;
constexpr double kRateHz = 32;
constexpr double kThirdOctave = 1.2589254117941673;  // ten bands a decade

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// 8 x 8 strands over a crown of 4.2 m.
const synthesis::WindRegion kCrown{.crown = synthesis::WindRegion::Box{{-2.1, -2.1, 1}, {2.1, 2.1, 5.2}}};
constexpr double kSpacingM = 0.6;

std::vector<Vec3> lattice_points() {
  std::vector<Vec3> points;
  for (int row = 0; row < 8; ++row) {
    for (int column = 0; column < 8; ++column) points.push_back({0, -2.1 + kSpacingM * column, 1 + kSpacingM * row});
  }
  return points;
}

std::vector<Vec3> points_anywhere(std::size_t count, std::uint64_t seed, double reach_along_m) {
  const RandomStream random(seed, 0);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    points.push_back({random.uniform(3 * i, -reach_along_m, reach_along_m), random.uniform(3 * i + 1, -2.1, 2.1),
                      random.uniform(3 * i + 2, 1, 5.2)});
  }
  return points;
}

// 60 branches of 50 points, 4 cm apart, in the order of a tree's nodes.
std::vector<Vec3> points_of_tree() {
  const RandomStream random(3, 0);
  std::vector<Vec3> points;
  for (std::size_t branch = 0; branch < 60; ++branch) {
    const double turn = random.uniform(2 * branch, 0, 6.28);
    const double foot_m = random.uniform(2 * branch + 1, 1, 4);
    for (int i = 0; i < 50; ++i) points.push_back({0.03 * i * std::cos(turn), 0.03 * i * std::sin(turn), foot_m + 0.025 * i});
  }
  return points;
}

Result<std::shared_ptr<const TurbulentWind>> make(const TurbulentWindOptions& options, int seed) {
  return TurbulentWind::make(options, static_cast<std::uint64_t>(seed), kCrown);
}

struct Band {
  double centre_hz;
  std::size_t first;
  std::size_t end;
};

std::vector<Band> bands(double low_hz, double high_hz, double period_s) {
  std::vector<Band> made;
  for (double hz = low_hz; hz * std::sqrt(kThirdOctave) < high_hz; hz *= kThirdOctave) {
    made.push_back({hz * std::sqrt(kThirdOctave), static_cast<std::size_t>(std::ceil(hz * period_s)),
                    static_cast<std::size_t>(std::ceil(hz * kThirdOctave * period_s))});
  }
  return made;
}

// Measured power / target by harmonic, mean over the points and seeds so far; one for each component.
using PowerRatios = std::array<std::vector<double>, 3>;

void add_ratios(const TurbulentWindOptions& options, const std::vector<Series>& all, double period_s, double weight,
                PowerRatios& ratios) {
  for (const Series& series : all) {
    const std::array<const std::vector<double>*, 3> components{&series.along, &series.across, &series.up};
    for (std::size_t c = 0; c < 3; ++c) {
      const Lines lines = synthesis::lines_of(*components[c]);
      ratios[c].resize(lines.size() / 2);
      for (std::size_t k = 1; k < ratios[c].size(); ++k) {
        const double target =
            gust_spectrum(options, static_cast<GustTables::Component>(c), static_cast<double>(k) / period_s) / period_s;
        ratios[c][k] += weight * 2 * std::norm(lines[k]) / target / static_cast<double>(all.size());
      }
    }
  }
}

// By decade: the component that is furthest from its target. The floor is the scatter of so few harmonics (one standard
// deviation), counting the strands of a seed as one.
void report_spectra(const PowerRatios& ratios, double period_s, const std::string& name, Figures& figures) {
  for (const auto& [low_hz, high_hz, decade] :
       {std::tuple{0.01, 0.1, "10_to_100_mhz"}, {0.1, 1.0, "0.1_to_1_hz"}, {1.0, 10.0, "1_to_10_hz"}}) {
    const auto decade_bands = bands(low_hz, high_hz, period_s);
    const auto count = static_cast<double>(decade_bands.size());
    double worst_db = 0;
    for (const auto& ratio : ratios) {
      double mean = 0;
      for (const Band& band : decade_bands) {
        for (std::size_t k = band.first; k < band.end; ++k)
          mean += ratio[k] / static_cast<double>(band.end - band.first) / count;
      }
      const double error_db = 10 * std::log10(mean);
      if (std::abs(error_db) > std::abs(worst_db)) worst_db = error_db;
    }
    double variance = 0;
    for (const Band& band : decade_bands)
      variance += 1 / (static_cast<double>(band.end - band.first) * kSeeds) / (count * count);
    figures[name + "_" + decade + "_error_db"] = worst_db;
    figures["floor_" + name + "_" + decade + "_error_db"] = 10 / std::log(10) * std::sqrt(variance);
  }
}

Result<void> measure_spectra(TurbulenceSpectrum spectrum, Figures& figures) {
  const TurbulentWindOptions options{.spectrum = spectrum};
  PowerRatios on_strands;
  PowerRatios between;
  for (int seed = 0; seed < kSeeds; ++seed) {
    // Seeds of its own for each spectrum, or all would share one draw of normal numbers.
    const auto wind = make(options, spectrum == TurbulenceSpectrum::kaimal ? kSeeds + seed : seed);
    if (!wind) return wind.error();
    const double period_s = (*wind)->period_s();
    add_ratios(options, series_at(**wind, lattice_points(), period_s, kRateHz), period_s, 1.0 / kSeeds, on_strands);
    const auto anywhere = points_anywhere(64, static_cast<std::uint64_t>(seed), 0);
    add_ratios(options, series_at(**wind, anywhere, period_s, kRateHz), period_s, 1.0 / kSeeds, between);
  }
  const std::string name(to_string(spectrum));
  report_spectra(on_strands, options.period_s, name + "_on_strands", figures);
  report_spectra(between, options.period_s, name + "_between_strands", figures);
  return {};
}

// RMS over third-octave bands from 0.05 to 5 Hz of measured - wanted root coherence of the component along, for pairs of
// points: every a with its b.
class CoherenceError {
 public:
  CoherenceError(std::vector<Vec3> firsts, Vec3 apart_m) : firsts_(std::move(firsts)), apart_m_(apart_m) {}

  void add(const TurbulentWind& wind) {
    std::vector<Vec3> seconds = firsts_;
    for (Vec3& point : seconds) point = {point.x, point.y + apart_m_.y, point.z + apart_m_.z};
    const auto a = series_at(wind, firsts_, wind.period_s(), kRateHz);
    const auto b = series_at(wind, seconds, wind.period_s(), kRateHz);
    const auto all = bands(0.05, 5, wind.period_s());
    means_.resize(all.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      const Lines lines_a = synthesis::lines_of(a[i].along);
      const Lines lines_b = synthesis::lines_of(b[i].along);
      for (std::size_t band = 0; band < all.size(); ++band) means_[band].add(lines_a, lines_b, all[band].first, all[band].end);
    }
  }
  double rms(const TurbulentWindOptions& options) const {
    const auto coherence = gust_coherence(options, GustTables::along);
    const auto all = bands(0.05, 5, options.period_s);
    double sum2 = 0;
    for (std::size_t band = 0; band < all.size(); ++band) {
      double wanted = 0;
      for (std::size_t k = all[band].first; k < all[band].end; ++k) {
        wanted += coherence.at(static_cast<double>(k) / options.period_s, apart_m_.y, apart_m_.z);
      }
      wanted /= static_cast<double>(all[band].end - all[band].first);
      sum2 += std::pow(means_[band].value() - wanted, 2);
    }
    return std::sqrt(sum2 / static_cast<double>(all.size()));
  }

 private:
  std::vector<Vec3> firsts_;
  Vec3 apart_m_;
  std::vector<synthesis::CoherenceMean> means_;
};

Result<void> measure_coherence(Figures& figures) {
  const TurbulentWindOptions options;
  std::vector<Vec3> lower_left;  // of the lattice: two strands to the right and above there are more
  for (const Vec3& point : lattice_points()) {
    if (point.y < 0.85 && point.z < 3.95) lower_left.push_back(point);
  }
  std::vector<Vec3> anywhere = points_anywhere(36, 5, 0);
  for (Vec3& point : anywhere) point = {0, (point.y + 2.1) * 0.7 - 2.1, (point.z - 1) * 0.7 + 1};
  std::vector<std::pair<std::string, CoherenceError>> errors;
  errors.emplace_back("lateral_strands_0.6_m", CoherenceError(lower_left, {0, kSpacingM, 0}));
  errors.emplace_back("lateral_strands_1.2_m", CoherenceError(lower_left, {0, 2 * kSpacingM, 0}));
  errors.emplace_back("vertical_strands_0.6_m", CoherenceError(lower_left, {0, 0, kSpacingM}));
  errors.emplace_back("vertical_strands_1.2_m", CoherenceError(lower_left, {0, 0, 2 * kSpacingM}));
  errors.emplace_back("lateral_anywhere_0.3_m", CoherenceError(anywhere, {0, kSpacingM / 2, 0}));
  errors.emplace_back("lateral_anywhere_0.6_m", CoherenceError(anywhere, {0, kSpacingM, 0}));
  errors.emplace_back("lateral_anywhere_1.2_m", CoherenceError(anywhere, {0, 2 * kSpacingM, 0}));
  errors.emplace_back("vertical_anywhere_0.6_m", CoherenceError(anywhere, {0, 0, kSpacingM}));
  for (int seed = 0; seed < kSeeds / 2; ++seed) {
    const auto wind = make(options, seed);
    if (!wind) return wind.error();
    for (auto& [name, error] : errors) error.add(**wind);
  }
  for (const auto& [name, error] : errors) figures["coherence_" + name + "_rms_error"] = error.rms(options);
  return {};
}

double lookup_ns(const WindField& wind, const std::vector<Vec3>& points) {
  std::vector<Vec3> out(points.size());
  constexpr int kSteps = 500;
  double best_s = 1e9;
  for (int round = 0; round < 5; ++round) {
    const double start_s = cpu_seconds();
    for (int step = 0; step < kSteps; ++step) wind.velocities_mps(points, 0.01 * step, out);
    best_s = std::min(best_s, cpu_seconds() - start_s);
  }
  return 1e9 * best_s / static_cast<double>(kSteps * points.size());
}

Result<void> measure_cost(Figures& figures) {
  double best_s = 1e9;
  Result<std::shared_ptr<const TurbulentWind>> wind = Error{ErrorCode::unsupported, ""};
  for (int round = 0; round < 3; ++round) {
    const double start_s = cpu_seconds();
    wind = make({.profile_exponent = 0.2}, 1);
    if (!wind) return wind.error();
    best_s = std::min(best_s, cpu_seconds() - start_s);
  }
  figures["strands"] = (*wind)->strands();
  figures["period_s"] = (*wind)->period_s();
  figures["generation_s"] = best_s;
  figures["size_bytes"] = (*wind)->bytes();
  figures["lookup_tree_of_3000_ns"] = lookup_ns(**wind, points_of_tree());
  figures["lookup_3000_anywhere_ns"] = lookup_ns(**wind, points_anywhere(3000, 9, 2.1));
  figures["lookup_one_ns"] = lookup_ns(**wind, {{0.3, 0.4, 2.2}});
  return {};
}

Result<Figures> wind() {
  Figures figures{{"case", "wind"}};
  if (auto done = measure_cost(figures); !done) return done.error();
  for (const auto spectrum : {TurbulenceSpectrum::von_karman, TurbulenceSpectrum::kaimal}) {
    if (auto done = measure_spectra(spectrum, figures); !done) return done.error();
  }
  if (auto done = measure_coherence(figures); !done) return done.error();
  return figures;
}

}  // namespace

void add_wind_cases(std::vector<Case>& cases) {
  cases.push_back({"wind", "spectra, coherence and cost of the simulated wind", wind});
}

}  // namespace roseau::bench
