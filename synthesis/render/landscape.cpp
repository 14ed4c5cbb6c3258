#include "synthesis/render/landscape.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/check.h"

namespace roseau::render {

namespace {

enum : std::uint64_t { kCloudStream = 101, kRidgeStream, kWoodStream, kMeadowStream, kHedgeStream };

constexpr Colour kHaze{0.86, 0.91, 0.94};
constexpr double kMeadowEdge = -0.022;  // where the wood stands: 70 m away, seen from 1.6 m up
constexpr double kHedgeY_m = 13;
constexpr double kHedgeHeight_m = 1.5;
constexpr double kGrassY_m = 7;
constexpr double kGrassHeight_m = 0.30;

constexpr int kCloudCells = Landscape::kCloudColumns / Landscape::kCloudPeriod;  // of the table, per unit
constexpr int kCloudRows = 11 * kCloudCells;
constexpr double kCloudUnitsPerMetre = 1.6e-3;

// 1 below the line, 0 above, with an edge one pixel soft.
double below(double line, double height, double pixel) { return smooth_step(-0.8 * pixel, 0.8 * pixel, line - height); }

void hide(Landscape::Look& look, const Colour& colour, double share) {
  look.solid = mix(look.solid, colour, share);
  look.sky_share *= 1 - share;
}

}  // namespace

GroundShadow::GroundShadow(double cell_m, int cells, std::vector<float> shade)
    : cell_m_(cell_m), cells_(cells), shade_(std::move(shade)) {
  ROSEAU_CHECK(cell_m > 0 && shade_.size() == static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
}

double GroundShadow::at(double x_m, double y_m) const {
  const double column = x_m / cell_m_ + cells_ / 2.0 - 0.5;
  const double row = y_m / cell_m_ + cells_ / 2.0 - 0.5;
  if (!(column >= 0 && row >= 0 && column < cells_ - 1 && row < cells_ - 1)) return 0;
  const auto i = static_cast<std::size_t>(column);
  const auto j = static_cast<std::size_t>(row);
  const double fx = column - static_cast<double>(i);
  const double fy = row - static_cast<double>(j);
  const float* cell = shade_.data() + j * static_cast<std::size_t>(cells_) + i;
  const float* above = cell + cells_;
  return (1 - fy) * ((1 - fx) * cell[0] + fx * cell[1]) + fy * ((1 - fx) * above[0] + fx * above[1]);
}

Landscape::Landscape(std::uint64_t seed, GroundShadow shadow)
    : shadow_(std::move(shadow)),
      ridge_(seed, kRidgeStream),
      wood_(seed, kWoodStream),
      meadow_(seed, kMeadowStream),
      hedge_(seed, kHedgeStream),
      clouds_(static_cast<std::size_t>(kCloudStride) * kCloudRows) {
  const ValueNoise noise(seed, kCloudStream, kCloudPeriod);
  auto cell = clouds_.begin();
  for (int row = 0; row < kCloudRows; ++row) {
    for (int column = 0; column < kCloudStride; ++column, ++cell) {
      const double density = noise.octaves(column / double{kCloudCells}, row / double{kCloudCells}, 5, 0.55);
      *cell = static_cast<float>(0.85 * smooth_step(0.50, 0.72, density));
    }
  }
}

Landscape::CloudCell Landscape::cloud_cell(const Vec2& cloud_point) {
  const double columns = cloud_point.x * kCloudCells;
  const double column = columns - kCloudColumns * std::floor(columns / kCloudColumns);
  const double row = std::clamp(cloud_point.y * kCloudCells, 0.0, kCloudRows - 2.0);
  const auto whole_row = static_cast<std::uint32_t>(row);
  return {static_cast<float>(column), static_cast<float>(row - whole_row), whole_row * kCloudStride};
}

Landscape::Look Landscape::look(const Vec3& from, const Vec3& ray, double pixel_rad) const {
  const double north = std::max(ray.y, 0.02 * std::hypot(ray.x, ray.y, ray.z));
  const double azimuth = ray.x / north;    // tangent: right of north
  const double elevation = ray.z / north;  // tangent: above the horizon

  Look look{.sky_share = 1};
  const double height = std::clamp(elevation / 0.42, 0.0, 1.0);
  look.clear_sky = mix({0.80, 0.89, 0.95}, {0.36, 0.58, 0.84}, std::pow(height, 0.8));
  // A sheet of cloud overhead: farther parts are seen flatter.
  const double flat = 1 / (std::max(elevation, 0.0) + 0.25);
  look.cloud_point = {azimuth * flat * 1.6 + from.x * kCloudUnitsPerMetre, flat * 2.6};

  hide(look, hill(azimuth, elevation, 9.1, {0.63, 0.73, 0.80}),
       below(ridge_line(azimuth, 2.1, 0.062, 0.030), elevation, pixel_rad));
  hide(look, hill(azimuth, elevation, 3.7, {0.47, 0.60, 0.58}),
       below(ridge_line(azimuth, 3.3, 0.040, 0.024), elevation, pixel_rad));
  hide(look, wood(azimuth, elevation), below(wood_line(azimuth), elevation, pixel_rad));
  hide(look, meadow(from, ray), below(kMeadowEdge, elevation, pixel_rad));
  if (ray.y > 0 && from.y < kGrassY_m - 1) {
    add_hedge(from, ray, pixel_rad, look);
    add_grass(from, ray, pixel_rad, look);
  }
  return look;
}

double Landscape::ridge_line(double azimuth, double scale, double height, double relief) const {
  return height + relief * (ridge_.octaves(azimuth * scale + 40 * scale, scale, 4) - 0.5) * 2;
}

double Landscape::wood_line(double azimuth) const {
  return 0.020 + 0.050 * wood_.octaves(azimuth * 9, 3.1, 2) + 0.020 * wood_.octaves(azimuth * 55, 7.7, 3, 0.6);
}

Colour Landscape::hill(double azimuth, double elevation, double offset, const Colour& colour) const {
  const double shade = ridge_.octaves(azimuth * 22 + offset, elevation * 60 + offset, 4);
  return mix(scaled(colour, 0.90 + 0.20 * shade), kHaze, 0.18);
}

// Crowns of far trees: clumps lit from above and the left, dark between.
Colour Landscape::wood(double azimuth, double elevation) const {
  const double clump = wood_.octaves(azimuth * 60, elevation * 75, 3, 0.6);
  const double lit = clump - wood_.octaves(azimuth * 60 - 0.35, elevation * 75 + 0.5, 3, 0.6);
  const double light = std::clamp(0.46 + 1.5 * lit + 0.45 * (clump - 0.5), 0.0, 1.0);
  const double species = wood_.at(azimuth * 11 + 5, 0.5);
  const Colour dark = mix({0.12, 0.22, 0.15}, {0.16, 0.24, 0.12}, species);
  const Colour bright = mix({0.40, 0.53, 0.30}, {0.56, 0.60, 0.28}, species);
  return mix(mix(dark, bright, light), kHaze, 0.12);
}

Colour Landscape::meadow(const Vec3& from, const Vec3& ray) const {
  const double reach = from.z / std::max(-ray.z, 1e-6);
  const double x = from.x + reach * ray.x;
  const double y = from.y + reach * ray.y;
  const double distance = reach * std::hypot(ray.x, ray.y);
  // Detail finer than a pixel would only flicker between the two cameras: it fades with distance.
  const double fine = std::clamp(0.03 * 800 / (distance * distance * 1.5), 0.0, 1.0);
  const double patches = meadow_.octaves(x * 0.22 + 50, y * 0.10 + 50, 4);
  const double tufts = meadow_.octaves(x * 2.4 + 90, y * 1.1, 3, 0.6);
  const double blades = meadow_.octaves(x * 34, y * 7, 2, 0.7);
  Colour colour = mix({0.33, 0.46, 0.17}, {0.68, 0.68, 0.32}, smooth_step(0.25, 0.75, patches));
  const double shade = 1 + 0.42 * (tufts - 0.5) * std::min(1.0, 14 / distance) + 0.75 * (blades - 0.5) * fine;
  colour = scaled(colour, 0.95 * shade);
  colour = mix(colour, {0.10 * shade, 0.17 * shade, 0.09 * shade}, 0.8 * shadow_.at(x, y));
  return mix(colour, kHaze, 0.22 * smooth_step(15, 90, distance));
}

void Landscape::add_hedge(const Vec3& from, const Vec3& ray, double pixel_rad, Look& look) const {
  const double reach = (kHedgeY_m - from.y) / ray.y;
  const double x = from.x + reach * ray.x;
  const double z = from.z + reach * ray.z;
  if (z < -0.1 || z > 1.6 * kHedgeHeight_m) return;
  const double distance = reach * std::hypot(ray.x, ray.y);
  const double top =
      kHedgeHeight_m * (0.62 + 0.40 * hedge_.octaves(x * 0.6, 1.7, 2) + 0.22 * hedge_.octaves(x * 5, 4.3, 3, 0.7));
  const double clump = hedge_.octaves(x * 3.1, z * 3.6, 4, 0.65);
  const double lit = clump - hedge_.octaves(x * 3.1 - 0.3, z * 3.6 + 0.4, 4, 0.65);
  const double light = std::clamp(0.30 + 1.7 * lit + 0.28 * z / kHedgeHeight_m, 0.0, 1.0);
  hide(look, mix({0.09, 0.15, 0.07}, {0.46, 0.53, 0.22}, light), below(top, z, pixel_rad * distance));
  const double height = std::clamp(z / kHedgeHeight_m, 0.0, 1.0);
  const double fade = 1 - smooth_step(1.1, 1.6, z / kHedgeHeight_m);  // the sky above stands still
  look.sway_rad_per_m = height * height * fade / distance;
}

void Landscape::add_grass(const Vec3& from, const Vec3& ray, double pixel_rad, Look& look) const {
  const double reach = (kGrassY_m - from.y) / ray.y;
  const double x = from.x + reach * ray.x;
  const double z = from.z + reach * ray.z;
  if (z < -0.1 || z > 1.8 * kGrassHeight_m) return;
  const double distance = reach * std::hypot(ray.x, ray.y);
  const double top =
      kGrassHeight_m * (0.35 + 0.75 * hedge_.octaves(x * 1.1, 31.7, 2) + 0.55 * hedge_.octaves(x * 16, 44.3, 3, 0.8) - 0.3);
  const double blades = hedge_.octaves(x * 22, z * 1.5 + 9, 3, 0.7);
  const double height = std::clamp(z / kGrassHeight_m, 0.0, 1.0);
  // Its foot goes over into the meadow.
  const double standing = smooth_step(-0.06, 0.14, z);
  hide(look, mix({0.24, 0.30, 0.11}, {0.74, 0.70, 0.36}, std::clamp(0.15 + 1.1 * (blades - 0.5) + 0.5 * height, 0.0, 1.0)),
       standing * below(top, z, pixel_rad * distance));
  const double fade = 1 - smooth_step(1.1, 1.8, z / kGrassHeight_m);
  look.sway_rad_per_m = std::max(look.sway_rad_per_m, 0.8 * height * fade / distance);
}

}  // namespace roseau::render
