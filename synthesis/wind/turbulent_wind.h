// TurbulentWind: a mean wind with turbulence of a stated spectrum that drifts with it unchanged (Taylor's frozen flow, plant
// thesis equation 5.5), over a region as large as a tree and its instruments.
//
// Along the mean wind the field is exact: what is at x now is at x + U dt in dt, at all heights with the U of the reference
// height (otherwise the gusts at different heights would slide apart). Across it, the field is defined on strands, lines
// parallel to the mean wind, that stand on a lattice (lateral x vertical): through every instrument, and over the crown at a
// chosen spacing. The strands have exactly the stated spectra and, between any two of them, Davenport's coherence
// (coherence.h). At a place between four strands:
//
//   velocity = bilinear mean of the four + what that mean has lost
//
// What is lost of the power is known: S(f) times the sum over pairs of strands of 2 w_i w_j (1 - coherence(f, i, j)). A series
// with that spectrum, independent of the strands, is added, one for each edge and each cell, scaled so that the field stays
// continuous. So every place has the stated spectrum, none is smoothed. What remains of an error is that places less than a
// spacing apart, inside a cell, are more alike at high frequencies than Davenport says: choose a spacing well below
// U / (decay f) for the highest frequency that matters. bench case `wind` measures this.
//
// The sd does not change with height (as in neutral air near the ground); the mean does (mean_wind.h). The three components
// are independent of each other: there is no downward flux of momentum. Outside the lattice the nearest strand is taken.
// Periodic in time (`period_s`). Memory: 0.52 MB per strand at 2048 s; 8 x 8 strands: 37 MB with what lies between. At most 400
// strands and 537 MB.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/result.h"
#include "core/wind_field.h"
#include "synthesis/wind/coherence.h"
#include "synthesis/wind/gust_sum.h"
#include "synthesis/wind/gust_tables.h"
#include "synthesis/wind/lattice_axis.h"
#include "synthesis/wind/mean_wind.h"
#include "synthesis/wind/spectrum.h"
#include "synthesis/wind/wind_region.h"

namespace roseau::synthesis {

struct TurbulentWindOptions {
  double mean_speed_mps = 4;
  double direction_from_deg = 270;    // where the wind comes from, clockwise from north
  double turbulence_intensity = 0.3;  // sd along / mean speed
  double across_sd_ratio = 0.8;       // sd of the horizontal component across / sd along
  double vertical_sd_ratio = 0.5;     // sd of the vertical component / sd along
  double length_scale_m = 30;         // of the component along
  double across_length_scale_m = 15;  // of the horizontal component across (half of it in isotropic turbulence)
  double lateral_decay = 10;          // Davenport's constant; 8 to 12 is usual over open country
  double reference_height_m = 2.6;    // where the mean is mean_speed_mps
  double profile_exponent = 0;        // power profile: mean ~ (height / reference)^exponent; 0 = the same at all heights
  double vertical_length_scale_m = 15;
  double vertical_decay = 10;
  TurbulenceSpectrum spectrum = TurbulenceSpectrum::von_karman;
  ProfileShape profile = ProfileShape::power;
  double roughness_length_m = 0.03;  // logarithmic profile
  double displacement_height_m = 0;  // logarithmic profile
  double strand_spacing_m = 0.6;     // of the lattice over the crown, at most
  double period_s =
      2048;  // after which the turbulence repeats; lengthened by up to a few per cent where that is faster to make
};

MeanProfileOptions profile_of(const TurbulentWindOptions& options);
/// Of a component (GustTables::along, across, up): its standard deviation, spectrum in (m/s)^2/Hz, and coherence.
double gust_sd_mps(const TurbulentWindOptions& options, GustTables::Component component);
double gust_spectrum(const TurbulentWindOptions& options, GustTables::Component component, double frequency_hz);
DavenportCoherence gust_coherence(const TurbulentWindOptions& options, GustTables::Component component);

class TurbulentWind final : public WindField {
 public:
  /// The lattice of a region. Error when the region is empty or not finite, or the lattice would be too large.
  static Result<std::shared_ptr<const TurbulentWind>> make(const TurbulentWindOptions& options, std::uint64_t seed,
                                                           const WindRegion& region);

  /// Strands through these points only; at least one. Options must be sensible (check() in wind_options.h).
  TurbulentWind(const TurbulentWindOptions& options, std::uint64_t seed, std::span<const Vec3> points_in_world);

  /// Places and times that are not finite, or too large to have a fraction, get NaN.
  Vec3 velocity_mps(const Vec3& point_in_world, double time_s) const override;
  void velocities_mps(std::span<const Vec3> points_in_world, double time_s, std::span<Vec3> out) const override;

  /// Unit vector of the mean wind's motion (towards), in the world's horizontal plane; and one to its left.
  Vec3 along() const { return along_; }
  Vec3 across() const { return {-along_.y, along_.x, 0}; }

  double period_s() const { return tables_ ? tables_->period_s() : options_.period_s; }
  std::size_t strands() const { return lateral_.size() * vertical_.size(); }
  std::size_t bytes() const { return tables_ ? tables_->bytes() : 0; }
  const LatticeAxis& lateral_axis() const { return lateral_; }    // positions along across()
  const LatticeAxis& vertical_axis() const { return vertical_; }  // heights

 private:
  TurbulentWind(const TurbulentWindOptions& options, std::uint64_t seed, LatticeAxis lateral, LatticeAxis vertical);
  void make_gusts(std::uint64_t seed);
  std::vector<Vec2> lost_separations() const;
  void index_cells();
  void read_gusts(const Vec3& point, double start_position, GustReading& reading) const;
  Vec3 mean_mps(double height_m) const;
  Vec3 velocity(const Vec3& point, const std::array<float, 4>& counts) const;

  TurbulentWindOptions options_;
  Vec3 along_;
  MeanProfile profile_;
  LatticeAxis lateral_;
  LatticeAxis vertical_;
  std::optional<GustTables> tables_;  // none without turbulence
  double steps_per_m_ = 0;            // table steps that the wind takes for a metre
  double table_size_ = 1;             // in steps, and its inverse
  double per_table_ = 1;
  // By strand number (row by row, from below), the cell to its upper right: where in the tables its terms start.
  std::vector<std::array<std::uint32_t, GustReading::kTerms>> cells_;
};

}  // namespace roseau::synthesis
