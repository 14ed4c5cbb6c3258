#include "synthesis/wind/turbulent_wind.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/check.h"
#include "core/random.h"
#include "synthesis/wind/coherent_spectra.h"

namespace roseau::synthesis {

namespace {
constexpr std::size_t kMostStrands = 400;
constexpr std::size_t kMostBytes = std::size_t{512} << 20U;
constexpr double kMegabyte = 1e6;

constexpr std::array kComponents{GustTables::along, GustTables::across, GustTables::up};

// The terms of a reading: four strands, what is lost along the four edges between them, and across.
enum Term : std::uint8_t { kHere, kRight, kAbove, kAboveRight, kBelowEdge, kAboveEdge, kLeftEdge, kRightEdge, kInside };

double length_scale_m(const TurbulentWindOptions& options, GustTables::Component component) {
  return component == GustTables::along    ? options.length_scale_m
         : component == GustTables::across ? options.across_length_scale_m
                                           : options.vertical_length_scale_m;
}

double lateral_of(const Vec3& point, const Vec3& along) { return point.y * along.x - point.x * along.y; }

std::vector<double> laterals_of(std::span<const Vec3> points, const Vec3& along) {
  std::vector<double> laterals;
  for (const Vec3& point : points) laterals.push_back(lateral_of(point, along));
  return laterals;
}

std::vector<double> heights_of(std::span<const Vec3> points) {
  std::vector<double> heights;
  for (const Vec3& point : points) heights.push_back(point.z);
  return heights;
}

// A box turned into the wind is seen from there as the range of its corners.
LatticeRange lateral_range(const WindRegion::Box& box, const Vec3& along) {
  const double a = box.low_in_world_m.y * along.x;
  const double b = box.high_in_world_m.y * along.x;
  const double c = -box.low_in_world_m.x * along.y;
  const double d = -box.high_in_world_m.x * along.y;
  return {std::min(a, b) + std::min(c, d), std::max(a, b) + std::max(c, d)};
}

bool is_finite(const Vec3& point) { return std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z); }

Result<void> check_region(const WindRegion& region) {
  const auto wrong = [](std::string what) { return Error{ErrorCode::invalid_argument, "wind: " + std::move(what)}; };
  if (!region.crown && region.instruments_in_world_m.empty()) return wrong("no place is given where it is wanted");
  if (!std::ranges::all_of(region.instruments_in_world_m, is_finite)) return wrong("an instrument's place is not a number");
  if (!region.crown) return {};
  const Vec3& low = region.crown->low_in_world_m;
  const Vec3& high = region.crown->high_in_world_m;
  if (!is_finite(low) || !is_finite(high) || low.x > high.x || low.y > high.y || low.z > high.z) {
    return wrong("the box of the crown has no inside");
  }
  return {};
}

// Before any line is made: a spacing of micrometres must not cost the memory that it is refused for.
double lines_over(const LatticeRange& range, std::size_t exact, double spacing_m) {
  return (range.high_m - range.low_m) / spacing_m + 2 * static_cast<double>(exact) + 2;
}
}  // namespace

MeanProfileOptions profile_of(const TurbulentWindOptions& options) {
  return {.shape = options.profile,
          .reference_height_m = options.reference_height_m,
          .exponent = options.profile_exponent,
          .roughness_length_m = options.roughness_length_m,
          .displacement_height_m = options.displacement_height_m};
}

double gust_sd_mps(const TurbulentWindOptions& options, GustTables::Component component) {
  const double ratio = component == GustTables::along    ? 1
                       : component == GustTables::across ? options.across_sd_ratio
                                                         : options.vertical_sd_ratio;
  return options.turbulence_intensity * options.mean_speed_mps * ratio;
}

double gust_spectrum(const TurbulentWindOptions& options, GustTables::Component component, double frequency_hz) {
  const auto spectrum = options.spectrum == TurbulenceSpectrum::kaimal ? kaimal
                        : component == GustTables::along               ? von_karman_along
                                                                       : von_karman_across;
  return spectrum(frequency_hz, options.mean_speed_mps, gust_sd_mps(options, component), length_scale_m(options, component));
}

DavenportCoherence gust_coherence(const TurbulentWindOptions& options, GustTables::Component component) {
  return {.mean_speed_mps = options.mean_speed_mps,
          .lateral_decay = options.lateral_decay,
          .vertical_decay = options.vertical_decay,
          .length_scale_m = length_scale_m(options, component)};
}

Result<std::shared_ptr<const TurbulentWind>> TurbulentWind::make(const TurbulentWindOptions& options, std::uint64_t seed,
                                                                 const WindRegion& region) {
  if (auto checked = check_region(region); !checked) return checked.error();
  const Vec3 along = towards_from_direction(options.direction_from_deg);
  std::optional<LatticeRange> lateral;
  std::optional<LatticeRange> vertical;
  const std::size_t exact = region.instruments_in_world_m.size();
  double most_strands = static_cast<double>(exact) * static_cast<double>(exact);
  if (region.crown) {
    lateral = lateral_range(*region.crown, along);
    vertical = LatticeRange{region.crown->low_in_world_m.z, region.crown->high_in_world_m.z};
    most_strands =
        lines_over(*lateral, exact, options.strand_spacing_m) * lines_over(*vertical, exact, options.strand_spacing_m);
  }
  const auto too_large = [&](double strands, double bytes) {
    return Error{ErrorCode::invalid_argument,
                 fmt::format("wind: {:.0f} strands of {} s would take {:.0f} MB (at most {} strands and {:.0f} MB): make "
                             "strand_spacing_m larger, period_s shorter, or the crown smaller",
                             strands, options.period_s, bytes / kMegabyte, kMostStrands, kMostBytes / kMegabyte)};
  };
  const auto table_bytes = static_cast<double>(GustTables::bytes_per_table(options.period_s));
  if (most_strands > 10 * kMostStrands) return too_large(most_strands, most_strands * table_bytes);

  LatticeAxis lateral_axis(laterals_of(region.instruments_in_world_m, along), lateral, options.strand_spacing_m);
  LatticeAxis vertical_axis(heights_of(region.instruments_in_world_m), vertical, options.strand_spacing_m);
  const std::size_t strands = lateral_axis.size() * vertical_axis.size();
  const std::size_t fillers = (lateral_axis.widths_m().size() + 1) * (vertical_axis.widths_m().size() + 1) - 1;
  const double bytes = static_cast<double>(strands + 2 * fillers) * table_bytes;
  if (strands > kMostStrands || bytes > static_cast<double>(kMostBytes)) return too_large(static_cast<double>(strands), bytes);
  return std::shared_ptr<const TurbulentWind>(
      new TurbulentWind(options, seed, std::move(lateral_axis), std::move(vertical_axis)));
}

TurbulentWind::TurbulentWind(const TurbulentWindOptions& options, std::uint64_t seed, std::span<const Vec3> points_in_world)
    : TurbulentWind(options, seed,
                    LatticeAxis(laterals_of(points_in_world, towards_from_direction(options.direction_from_deg)), {},
                                options.strand_spacing_m),
                    LatticeAxis(heights_of(points_in_world), {}, options.strand_spacing_m)) {}

TurbulentWind::TurbulentWind(const TurbulentWindOptions& options, std::uint64_t seed, LatticeAxis lateral, LatticeAxis vertical)
    : options_(options),
      along_(towards_from_direction(options.direction_from_deg)),
      profile_(profile_of(options)),
      lateral_(std::move(lateral)),
      vertical_(std::move(vertical)),
      steps_per_m_(kGustRateHz / options.mean_speed_mps) {
  ROSEAU_CHECK(options.mean_speed_mps > 0);
  if (options.turbulence_intensity > 0) make_gusts(seed);
}

void TurbulentWind::make_gusts(std::uint64_t seed) {
  std::vector<Vec2> places;
  for (const double height_m : vertical_.lines_m()) {
    for (const double lateral_m : lateral_.lines_m()) places.push_back({lateral_m, height_m});
  }
  const std::vector<Vec2> losses = lost_separations();
  tables_.emplace(places.size(), losses.size(), options_.period_s,
                  std::array{gust_sd_mps(options_, GustTables::along), gust_sd_mps(options_, GustTables::across),
                             gust_sd_mps(options_, GustTables::up)});
  table_size_ = static_cast<double>(tables_->size());
  per_table_ = 1 / table_size_;
  index_cells();
  const double period_s = tables_->period_s();
  for (const GustTables::Component component : kComponents) {
    const DavenportCoherence coherence = gust_coherence(options_, component);
    std::vector<float> amplitude(tables_->harmonics());
    for (std::size_t k = 0; k < amplitude.size(); ++k) {
      const double power = gust_spectrum(options_, component, static_cast<double>(k + 1) / period_s) / period_s;
      amplitude[k] = static_cast<float>(std::sqrt(power));
    }
    const std::uint64_t its_seed = scatter_bits(seed + component);
    tables_->make(component, 0, coherent_amplitudes(places, coherence, amplitude, period_s, its_seed));
    for (std::size_t i = 0; i < losses.size(); ++i) {
      const double separation_s = coherence.separation_s(losses[i].x, losses[i].y);
      const std::size_t row = places.size() + i;
      tables_->make(component, row, lost_amplitudes(separation_s, coherence, amplitude, period_s, its_seed, row));
    }
  }
}

// One filler for each different distance between neighbours: lateral, vertical, then diagonal.
std::vector<Vec2> TurbulentWind::lost_separations() const {
  std::vector<Vec2> losses;
  for (const double lateral_m : lateral_.widths_m()) losses.push_back({lateral_m, 0});
  for (const double vertical_m : vertical_.widths_m()) losses.push_back({0, vertical_m});
  for (const double vertical_m : vertical_.widths_m()) {
    for (const double lateral_m : lateral_.widths_m()) losses.push_back({lateral_m, vertical_m});
  }
  return losses;
}

// All edges and cells of one size share a filler, which each reads at a time of its own, spread evenly by the golden section.
void TurbulentWind::index_cells() {
  const std::size_t columns = lateral_.size();
  const std::size_t laterals = lateral_.widths_m().size();
  const std::size_t verticals = vertical_.widths_m().size();
  const auto start_of = [&](std::size_t loss, std::size_t edge) {
    const double turns = static_cast<double>(edge) * (std::numbers::phi - 1);
    return tables_->start(strands() + loss) + static_cast<std::uint32_t>((turns - std::floor(turns)) * table_size_);
  };
  cells_.resize(strands());
  for (std::size_t strand = 0; strand < strands(); ++strand) {
    const std::size_t row = strand / columns;
    const std::size_t column = strand % columns;
    const bool has_right = column + 1 < columns;
    const bool has_above = row + 1 < vertical_.size();
    std::array<std::uint32_t, GustReading::kTerms>& starts = cells_[strand];
    starts.fill(tables_->start(strand));  // where there is no neighbour, no share of it will be asked for
    if (has_right) {
      starts[kRight] = tables_->start(strand + 1);
      starts[kBelowEdge] = start_of(lateral_.width_index(column), 3 * strand);
    }
    if (has_above) {
      starts[kAbove] = tables_->start(strand + columns);
      starts[kLeftEdge] = start_of(laterals + vertical_.width_index(row), 3 * strand + 1);
    }
    if (has_right && has_above) {
      starts[kAboveRight] = tables_->start(strand + columns + 1);
      starts[kAboveEdge] = start_of(lateral_.width_index(column), 3 * (strand + columns));
      starts[kRightEdge] = start_of(laterals + vertical_.width_index(row), 3 * (strand + 1) + 1);
      const std::size_t diagonal = vertical_.width_index(row) * laterals + lateral_.width_index(column);
      starts[kInside] = start_of(laterals + verticals + diagonal, 3 * strand + 2);
    }
  }
}

// See the header. With the weights of a bilinear mean the loss splits into one part along each edge, fading towards the
// opposite edge, and one for the diagonals, which is zero on all edges.
void TurbulentWind::read_gusts(const Vec3& point, double start_position, GustReading& reading) const {
  double position = start_position - (point.x * along_.x + point.y * along_.y) * steps_per_m_;
  position -= table_size_ * std::floor(position * per_table_);
  position += 0 * point.z;
  const bool is_inside = position >= 0 && position <= table_size_;  // else it is no number, or too large to have a fraction
  const std::int32_t entry = is_inside ? static_cast<std::int32_t>(position) : 0;
  const double fraction = is_inside ? position - static_cast<double>(entry) : std::numeric_limits<double>::quiet_NaN();
  const LatticeAxis::Place lateral = lateral_.locate(lateral_of(point, along_));
  const LatticeAxis::Place vertical = vertical_.locate(point.z);

  reading.entries = tables_->entries() + entry;
  reading.starts = cells_[vertical.line * lateral_.size() + lateral.line].data();
  reading.weights = cubic_weights(static_cast<float>(fraction));
  const float s = lateral.share;
  const float t = vertical.share;
  const float from_s = 1 - s;
  const float from_t = 1 - t;
  const float between_s = std::sqrt(2 * s * from_s);
  const float between_t = std::sqrt(2 * t * from_t);
  reading.shares[kHere] = from_s * from_t;
  reading.shares[kRight] = s * from_t;
  reading.shares[kAbove] = from_s * t;
  reading.shares[kAboveRight] = s * t;
  reading.shares[kBelowEdge] = between_s * from_t;
  reading.shares[kAboveEdge] = between_s * t;
  reading.shares[kLeftEdge] = between_t * from_s;
  reading.shares[kRightEdge] = between_t * s;
  reading.shares[kInside] = between_s * between_t;
  for (std::size_t i = 0; i < GustReading::kTerms; ++i) __builtin_prefetch(reading.entries + reading.starts[i]);
}

Vec3 TurbulentWind::mean_mps(double height_m) const {
  const double speed_mps = options_.mean_speed_mps * profile_.ratio(height_m);
  return {speed_mps * along_.x, speed_mps * along_.y, 0};
}

Vec3 TurbulentWind::velocity(const Vec3& point, const std::array<float, 4>& counts) const {
  const std::array<float, 4>& to_mps = tables_->to_mps();
  const double along_mps =
      options_.mean_speed_mps * profile_.ratio(point.z) + static_cast<double>(counts[GustTables::along] * to_mps[0]);
  const auto across_mps = static_cast<double>(counts[GustTables::across] * to_mps[1]);
  const auto up_mps = static_cast<double>(counts[GustTables::up] * to_mps[2]);
  return {along_mps * along_.x - across_mps * along_.y, along_mps * along_.y + across_mps * along_.x, up_mps};
}

Vec3 TurbulentWind::velocity_mps(const Vec3& point_in_world, double time_s) const {
  Vec3 velocity;
  velocities_mps({&point_in_world, 1}, time_s, {&velocity, 1});
  return velocity;
}

void TurbulentWind::velocities_mps(std::span<const Vec3> points_in_world, double time_s, std::span<Vec3> out) const {
  ROSEAU_CHECK(out.size() == points_in_world.size());
  if (!tables_) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = mean_mps(points_in_world[i].z);
    return;
  }
  const double start = std::fmod(time_s, tables_->period_s()) * kGustRateHz;
  // In blocks: all places of one are found, and on their way into the processor, before the first is summed.
  constexpr std::size_t kBlock = 16;
  std::array<GustReading, kBlock> readings;
  std::array<std::array<float, 4>, kBlock> sums;
  for (std::size_t first = 0; first < out.size(); first += kBlock) {
    const std::size_t count = std::min(kBlock, out.size() - first);
    for (std::size_t i = 0; i < count; ++i) {
      read_gusts(points_in_world[first + i], start, readings[i]);
    }
    sum_gusts(std::span(readings).first(count), std::span(sums).first(count));
    for (std::size_t i = 0; i < count; ++i) out[first + i] = velocity(points_in_world[first + i], sums[i]);
  }
}

}  // namespace roseau::synthesis
