#include "structure/animation/gust_wind.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "structure/animation/forest_kernels.h"

namespace roseau::structure {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr std::size_t kBatch = 4 * kTile;  // points at once
constexpr std::size_t kMostWaves = 32;     // waves at once

}  // namespace

GustWind::GustWind(const Vec3& mean_mps, std::span<const Gust> gusts) : mean_mps_(mean_mps) {
  const double speed_mps = std::hypot(mean_mps.x, mean_mps.y);
  along_ = speed_mps > 0 ? Vec3{mean_mps.x / speed_mps, mean_mps.y / speed_mps, 0} : Vec3{1, 0, 0};
  for (const Gust& gust : gusts) {
    ROSEAU_CHECK(gust.wavelength_m > 0);
    const double wave_number = kTurn / gust.wavelength_m;
    const double c = std::cos(gust.direction_rad);
    const double s = std::sin(gust.direction_rad);
    const double east_per_m = wave_number * (along_.x * c - along_.y * s);
    const double north_per_m = wave_number * (along_.y * c + along_.x * s);
    waves_.push_back({.east_per_m = east_per_m,
                      .north_per_m = north_per_m,
                      .per_s = east_per_m * mean_mps.x + north_per_m * mean_mps.y,
                      .phase_rad = gust.phase_rad,
                      .along_mps = gust.along_mps,
                      .across_mps = gust.across_mps});
  }
}

GustWind GustWind::with_intensity(const Vec3& mean_mps, double intensity, std::size_t count) {
  const double deviation_mps = intensity * std::hypot(mean_mps.x, mean_mps.y);
  const double amplitude_mps = deviation_mps * std::sqrt(2.0 / static_cast<double>(std::max<std::size_t>(count, 1)));
  std::vector<Gust> gusts(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto step = static_cast<double>(i);
    // Steps by irrational numbers keep directions and phases from falling into a pattern.
    gusts[i] = {.wavelength_m = 200 * std::pow(0.1, count > 1 ? step / static_cast<double>(count - 1) : 0),
                .direction_rad = 0.9 * (std::fmod(step * std::numbers::phi, 1.0) - 0.5),
                .phase_rad = kTurn * std::fmod(step * std::numbers::sqrt2, 1.0),
                .along_mps = amplitude_mps,
                .across_mps = (i % 2 == 0 ? 0.5 : -0.5) * amplitude_mps};
  }
  return {mean_mps, gusts};
}

Vec3 GustWind::velocity_mps(const Vec3& point_in_world, double time_s) const {
  Vec3 velocity;
  velocities_mps({&point_in_world, 1}, time_s, {&velocity, 1});
  return velocity;
}

void GustWind::velocities_mps(std::span<const Vec3> points_in_world, double time_s, std::span<Vec3> out) const {
  ROSEAU_CHECK(out.size() == points_in_world.size());
  for (std::size_t begin = 0; begin < out.size(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, out.size() - begin);
    std::fill_n(out.begin() + static_cast<std::ptrdiff_t>(begin), count, mean_mps_);
    add_gusts(points_in_world.subspan(begin, count), time_s, out.subspan(begin, count));
  }
}

void GustWind::add_gusts(std::span<const Vec3> points_in_world, double time_s, std::span<Vec3> velocities_mps) const {
  alignas(64) std::array<float, kBatch> east{};
  alignas(64) std::array<float, kBatch> north{};
  alignas(64) std::array<float, kBatch> along{};
  alignas(64) std::array<float, kBatch> across{};
  for (std::size_t i = 0; i < points_in_world.size(); ++i) {
    east[i] = static_cast<float>(points_in_world[i].x);
    north[i] = static_cast<float>(points_in_world[i].y);
  }
  const std::size_t padded = (points_in_world.size() + kTile - 1) / kTile * kTile;
  std::array<GustPhase, kMostWaves> phases{};
  for (std::size_t first = 0; first < waves_.size(); first += kMostWaves) {
    const std::size_t count = std::min(kMostWaves, waves_.size() - first);
    for (std::size_t i = 0; i < count; ++i) {
      const Wave& wave = waves_[first + i];
      phases[i] = {.east_per_m = static_cast<float>(wave.east_per_m),
                   .north_per_m = static_cast<float>(wave.north_per_m),
                   .phase = static_cast<float>(std::remainder(wave.phase_rad - wave.per_s * time_s, kTurn)),
                   .along = static_cast<float>(wave.along_mps),
                   .across = static_cast<float>(wave.across_mps)};
    }
    sum_gusts(phases.data(), count, east.data(), north.data(), padded, along.data(), across.data());
    for (std::size_t i = 0; i < velocities_mps.size(); ++i) {
      velocities_mps[i].x += along_.x * along[i] - along_.y * across[i];
      velocities_mps[i].y += along_.y * along[i] + along_.x * across[i];
    }
  }
}

}  // namespace roseau::structure
