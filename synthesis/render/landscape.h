// Landscape: what lies around the tree as far as the sky: drifting clouds, hills, a wood, a hedge and tall grass that sway, a
// meadow with the tree's shadow. A function of place and direction, so that all cameras see the same one, each from where it
// stands.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry.h"
#include "synthesis/render/colour.h"
#include "synthesis/render/value_noise.h"

namespace roseau::render {

/// How much of the sun reaches places on the ground.
class GroundShadow {
 public:
  GroundShadow() = default;  // none
  /// A square of `cells` x `cells` around the origin; `shade` row by row, 0 (sun) to 1.
  GroundShadow(double cell_m, int cells, std::vector<float> shade);
  double at(double x_m, double y_m) const;

 private:
  double cell_m_ = 1;
  int cells_ = 0;
  std::vector<float> shade_;
};

class Landscape {
 public:
  Landscape(std::uint64_t seed, GroundShadow shadow);

  /// What is seen along a ray.
  struct Look {
    Colour solid;          // what hides the sky
    double sky_share = 0;  // how much of the sky it leaves visible: an edge is soft over one pixel
    Colour clear_sky;
    Vec2 cloud_point;  // where in the sheet of clouds the ray ends: cloud_cell()'s argument
    /// How far this place moves sideways, in radians of view, while hedge and grass sway by one metre at their tops.
    double sway_rad_per_m = 0;
  };
  /// `ray` of any length, towards the north; `pixel_rad`: angle that one pixel sees.
  Look look(const Vec3& from, const Vec3& ray, double pixel_rad) const;

  /// A place in the sheet of clouds, found once for a pixel; `drift_columns` then moves the clouds to the east.
  struct CloudCell {
    float column = 0;
    float row_share = 0;
    std::uint32_t row = 0;  // index of its first column
  };
  static CloudCell cloud_cell(const Vec2& cloud_point);
  /// 0..1 of the sky hidden by cloud. `drift_columns` in [0, kCloudColumns).
  float cloud_cover(const CloudCell& cell, float drift_columns) const {
    float column = cell.column - drift_columns;
    if (column < 0) column += kCloudColumns;
    const auto left = static_cast<std::uint32_t>(column);
    const float share = column - static_cast<float>(left);
    const float* low = clouds_.data() + cell.row + left;
    const float* high = low + kCloudStride;
    const float below = low[0] + share * (low[1] - low[0]);
    return below + cell.row_share * (high[0] + share * (high[1] - high[0]) - below);
  }
  static constexpr int kCloudPeriod = 16;  // the sheet repeats after that many units of cloud_point
  static constexpr int kCloudColumns = 1024;
  static constexpr double kCloudColumnsPerMetre = 1.6e-3 * kCloudColumns / kCloudPeriod;

 private:
  double ridge_line(double azimuth, double scale, double height, double relief) const;
  Colour hill(double azimuth, double elevation, double offset, const Colour& colour) const;
  double wood_line(double azimuth) const;
  Colour wood(double azimuth, double elevation) const;
  Colour meadow(const Vec3& from, const Vec3& ray) const;
  void add_hedge(const Vec3& from, const Vec3& ray, double pixel_rad, Look& look) const;
  void add_grass(const Vec3& from, const Vec3& ray, double pixel_rad, Look& look) const;

  static constexpr int kCloudStride = kCloudColumns + 2;  // the first columns again at the end, for interpolation

  GroundShadow shadow_;
  ValueNoise ridge_;
  ValueNoise wood_;
  ValueNoise meadow_;
  ValueNoise hedge_;
  std::vector<float> clouds_;  // one period, row by row
};

}  // namespace roseau::render
