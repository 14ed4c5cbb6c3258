#include "synthesis/render/backdrop.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>

namespace roseau::render {

namespace {

// Rays are unprojected on a grid and interpolated between: lens distortion bends them by less than 1e-5 within a cell.
constexpr int kGrid = 8;
constexpr double kCloudStep_s = 0.2;  // clouds are redrawn that often: they move by about a pixel

class RayGrid {
 public:
  explicit RayGrid(const calib::Projection& projection)
      : columns_(static_cast<int>(projection.camera().width) / kGrid + 2),
        rows_(static_cast<int>(projection.camera().height) / kGrid + 2) {
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        rays_.push_back(projection.ray_in_world({double{kGrid} * column, double{kGrid} * row}));
      }
    }
  }

  // Not of unit length; empty where the lens sees nothing.
  std::optional<Vec3> at(int x, int y) const {
    const double fx = x % kGrid / double{kGrid};
    const double fy = y % kGrid / double{kGrid};
    const std::optional<Vec3>* corner = rays_.data() + y / kGrid * columns_ + x / kGrid;
    const std::optional<Vec3>* below = corner + columns_;
    if (!corner[0] || !corner[1] || !below[0] || !below[1]) return std::nullopt;
    const auto blend = [fx, fy](double a, double b, double c, double d) {
      return (1 - fy) * ((1 - fx) * a + fx * b) + fy * ((1 - fx) * c + fx * d);
    };
    return Vec3{blend(corner[0]->x, corner[1]->x, below[0]->x, below[1]->x),
                blend(corner[0]->y, corner[1]->y, below[0]->y, below[1]->y),
                blend(corner[0]->z, corner[1]->z, below[0]->z, below[1]->z)};
  }

 private:
  int columns_;
  int rows_;
  std::vector<std::optional<Vec3>> rays_;
};

constexpr Colour kCloudColour{0.985, 0.985, 0.98};

}  // namespace

Backdrop::Backdrop(const VisibleScene& scene, const calib::Projection& projection, const InkMaker& ink)
    : scene_(scene),
      still_(static_cast<int>(projection.camera().width), static_cast<int>(projection.camera().height), ink.channels()),
      wave_(projection.camera().width),
      cloud_(ink(kCloudColour)) {
  if (scene.description().background.visible) {
    paint_landscape(projection, ink);
  } else {
    const Ink plain = ink(scene.description().background.plain);
    const auto channels = static_cast<std::size_t>(still_.channels);
    for (std::size_t i = 0; i < still_.steps.size(); ++i) still_.steps[i] = to_steps(plain.at(i % channels));
  }
  now_ = still_;
  cloud_steps_.fill(std::numeric_limits<std::int64_t>::min());
}

void Backdrop::paint_landscape(const calib::Projection& projection, const InkMaker& ink) {
  const RayGrid rays(projection);
  for (int y = 0; y < still_.height; ++y) {
    SwayingRow row{.y = y, .reach_px = std::vector<float>(static_cast<std::size_t>(still_.width))};
    for (int x = 0; x < still_.width; ++x) {
      if (const std::optional<Vec3> ray = rays.at(x, y)) paint_pixel(x, y, *ray, projection.camera(), ink, row);
    }
    if (std::ranges::any_of(row.reach_px, [](float reach) { return reach > 0; })) swaying_.push_back(std::move(row));
  }
}

void Backdrop::paint_pixel(int x, int y, const Vec3& ray, const calib::CameraModel& camera, const InkMaker& ink,
                           SwayingRow& row) {
  const Landscape::Look look = scene_.landscape().look(camera.position_in_world_m, ray, 1 / camera.fx_px());
  const auto index = static_cast<std::size_t>(y) * static_cast<std::size_t>(still_.width) + static_cast<std::size_t>(x);
  const Ink solid = ink(look.solid);
  const auto channels = static_cast<std::size_t>(still_.channels);
  for (std::size_t c = 0; c < channels; ++c) {
    still_.steps[index * channels + c] = to_steps(static_cast<float>(1 - look.sky_share) * solid.at(c));
  }
  if (look.sky_share > 1e-3) {
    sky_.push_back({static_cast<std::uint32_t>(index), static_cast<float>(look.sky_share),
                    Landscape::cloud_cell(look.cloud_point), ink(look.clear_sky)});
  }
  row.reach_px[static_cast<std::size_t>(x)] =
      static_cast<float>(look.sway_rad_per_m * camera.fx_px() * scene_.description().background.hedge_sway_m);
}

void Backdrop::drift_clouds(double time_s) {
  for (std::size_t group = 0; group < kCloudGroups; ++group) {
    const double phase = static_cast<double>(group) / kCloudGroups;
    const auto step = static_cast<std::int64_t>(std::floor(time_s / kCloudStep_s + phase));
    if (step == cloud_steps_.at(group)) continue;
    cloud_steps_.at(group) = step;
    drift_group(group, (static_cast<double>(step) - phase) * kCloudStep_s * scene_.description().background.cloud_speed_mps);
  }
}

void Backdrop::drift_group(std::size_t group, double drift_m) {
  const double columns = drift_m * Landscape::kCloudColumnsPerMetre;
  const auto drift = static_cast<float>(columns - Landscape::kCloudColumns * std::floor(columns / Landscape::kCloudColumns));
  const auto channels = static_cast<std::size_t>(now_.channels);
  const std::size_t begin = sky_.size() * group / kCloudGroups;
  const std::size_t end = sky_.size() * (group + 1) / kCloudGroups;
  for (const SkyPixel& pixel : std::span(sky_).subspan(begin, end - begin)) {
    const float cover = scene_.landscape().cloud_cover(pixel.cloud, drift);
    for (std::size_t c = 0; c < channels; ++c) {
      const float light = pixel.clear[c] + cover * (cloud_[c] - pixel.clear[c]);
      const std::size_t at = pixel.pixel * channels + c;
      now_.steps[at] = static_cast<std::uint16_t>(still_.steps[at] + static_cast<int>(pixel.share * light));
    }
  }
}

// Rows read their pixels from a little to the side, between two neighbours.
void Backdrop::sway(double time_s, double sway, Picture& picture) {
  constexpr double kTurn = 2 * std::numbers::pi;
  for (std::size_t x = 0; x < wave_.size(); ++x) {
    const double place = static_cast<double>(x) / static_cast<double>(wave_.size());
    wave_[x] = static_cast<float>(sway * (0.55 * std::sin(kTurn * (0.71 * time_s - 2.3 * place)) +
                                          0.30 * std::sin(kTurn * (1.13 * time_s - 5.9 * place + 0.3)) +
                                          0.15 * std::sin(kTurn * (1.87 * time_s - 13.1 * place + 0.7))));
  }
  const auto last = static_cast<float>(picture.width - 1);
  const int channels = picture.channels;
  for (const SwayingRow& row : swaying_) {
    const std::uint16_t* from = now_.row(row.y);
    std::uint16_t* to = picture.row(row.y);
    for (int x = 0; x < picture.width; ++x, to += channels) {
      const float reach = row.reach_px[static_cast<std::size_t>(x)];
      if (reach == 0) continue;
      const float at = std::clamp(static_cast<float>(x) - reach * wave_[static_cast<std::size_t>(x)], 0.0F, last);
      const int left = std::min(static_cast<int>(at), picture.width - 2);
      const int share = static_cast<int>((at - static_cast<float>(left)) * 256);
      const std::uint16_t* pixel = from + static_cast<std::size_t>(left) * static_cast<std::size_t>(channels);
      for (int c = 0; c < channels; ++c) {
        to[c] = static_cast<std::uint16_t>(pixel[c] + (((pixel[c + channels] - pixel[c]) * share) >> 8));
      }
    }
  }
}

void Backdrop::paint(double time_s, double sway_level, Picture& picture) {
  if (!sky_.empty()) drift_clouds(time_s);
  std::ranges::copy(now_.steps, picture.steps.begin());
  if (!swaying_.empty()) sway(time_s, sway_level, picture);
}

}  // namespace roseau::render
