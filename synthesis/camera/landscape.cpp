#include "synthesis/camera/landscape.h"

#include <algorithm>
#include <cmath>

#include "synthesis/camera/canvas.h"
#include "synthesis/camera/pinhole.h"
#include "synthesis/random.h"

namespace roseau::synthesis {

namespace {

// Smooth noise over a plane, 0..1: random values on a unit lattice, interpolated with continuous slope.
class ValueNoise {
 public:
  ValueNoise(std::uint64_t seed, std::uint64_t stream) : random_(seed, stream) {}

  double at(double x, double y) const {
    const double x0 = std::floor(x);
    const double y0 = std::floor(y);
    const double sx = ease(x - x0);
    const double sy = ease(y - y0);
    const auto i = static_cast<std::int64_t>(x0);
    const auto j = static_cast<std::int64_t>(y0);
    const double low = lattice(i, j) + sx * (lattice(i + 1, j) - lattice(i, j));
    const double high = lattice(i, j + 1) + sx * (lattice(i + 1, j + 1) - lattice(i, j + 1));
    return low + sy * (high - low);
  }

  /// Sum of octaves, each twice as fine and `roughness` times as strong; 0..1, mean 0.5.
  double octaves(double x, double y, int count, double roughness = 0.5) const {
    double sum = 0;
    double weight = 1;
    double weights = 0;
    for (int octave = 0; octave < count; ++octave) {
      sum += weight * at(x, y);
      weights += weight;
      weight *= roughness;
      x = 2 * x + 17.3;
      y = 2 * y + 5.9;
    }
    return sum / weights;
  }

 private:
  static double ease(double s) { return s * s * (3 - 2 * s); }
  double lattice(std::int64_t i, std::int64_t j) const {
    return random_.uniform((static_cast<std::uint64_t>(i) << 32U) ^ (static_cast<std::uint64_t>(j) & 0xFFFFFFFFU));
  }
  RandomStream random_;
};

double smooth_step(double low, double high, double value) {
  const double s = std::clamp((value - low) / (high - low), 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

constexpr Colour kHaze{0.86, 0.91, 0.94};

class Landscape {
 public:
  Landscape(const CameraCalibration& camera, std::uint64_t seed)
      : camera_(camera),
        pixel_(1 / camera.fx_px),
        clouds_(seed, 101),
        ridge_(seed, 102),
        wood_(seed, 103),
        meadow_(seed, 104) {}

  Colour colour_at(const Vec2& image_point) const {
    const Vec3 ray = ray_in_world(camera_, image_point);
    const double azimuth = ray.x / ray.y;    // tangent: right of north
    const double elevation = ray.z / ray.y;  // tangent: above the horizon
    Colour colour = sky(azimuth, elevation);
    colour = mix(colour, hill(azimuth, elevation, 9.1, {0.63, 0.73, 0.80}),
                 below(ridge_line(azimuth, 2.1, 0.062, 0.030), elevation));
    colour = mix(colour, hill(azimuth, elevation, 3.7, {0.47, 0.60, 0.58}),
                 below(ridge_line(azimuth, 3.3, 0.040, 0.024), elevation));
    colour = mix(colour, wood(azimuth, elevation), below(wood_line(azimuth), elevation));
    return mix(colour, meadow(ray), below(kMeadowEdge, elevation));
  }

 private:
  static constexpr double kMeadowEdge = -0.022;  // where the wood stands: 70 m away, seen from 1.6 m up

  // 1 below the line, 0 above, with an edge one pixel soft.
  double below(double line, double elevation) const { return smooth_step(-0.8 * pixel_, 0.8 * pixel_, line - elevation); }

  double ridge_line(double azimuth, double scale, double height, double relief) const {
    return height + relief * (ridge_.octaves(azimuth * scale + 40 * scale, scale, 4) - 0.5) * 2;
  }

  double wood_line(double azimuth) const {
    return 0.020 + 0.050 * wood_.octaves(azimuth * 9, 3.1, 2) + 0.020 * wood_.octaves(azimuth * 55, 7.7, 3, 0.6);
  }

  Colour sky(double azimuth, double elevation) const {
    const double height = std::clamp(elevation / 0.42, 0.0, 1.0);
    const Colour blue = mix({0.80, 0.89, 0.95}, {0.36, 0.58, 0.84}, std::pow(height, 0.8));
    // A sheet of cloud overhead: farther parts are seen flatter.
    const double flat = 1 / (elevation + 0.25);
    const double density = clouds_.octaves(azimuth * flat * 1.6 + 3.0, flat * 2.6, 5, 0.55);
    const double cloud = 0.85 * smooth_step(0.50, 0.72, density);
    return mix(blue, {0.985, 0.985, 0.98}, cloud);
  }

  Colour hill(double azimuth, double elevation, double offset, const Colour& colour) const {
    const double shade = ridge_.octaves(azimuth * 22 + offset, elevation * 60 + offset, 4);
    return mix(scaled(colour, 0.90 + 0.20 * shade), kHaze, 0.18);
  }

  // Crowns of far trees: clumps lit from above and the left, dark between.
  Colour wood(double azimuth, double elevation) const {
    const double clump = wood_.octaves(azimuth * 60, elevation * 75, 3, 0.6);
    const double lit = clump - wood_.octaves(azimuth * 60 - 0.35, elevation * 75 + 0.5, 3, 0.6);
    const double light = std::clamp(0.46 + 1.5 * lit + 0.45 * (clump - 0.5), 0.0, 1.0);
    const double species = wood_.at(azimuth * 11 + 5, 0.5);
    const Colour dark = mix({0.12, 0.22, 0.15}, {0.16, 0.24, 0.12}, species);
    const Colour bright = mix({0.40, 0.53, 0.30}, {0.56, 0.60, 0.28}, species);
    return mix(mix(dark, bright, light), kHaze, 0.12);
  }

  Colour meadow(const Vec3& ray) const {
    const double reach = camera_.position_in_world_m.z / std::max(-ray.z, 1e-6);
    const double x = camera_.position_in_world_m.x + reach * ray.x;
    const double y = camera_.position_in_world_m.y + reach * ray.y;
    const double distance = reach * std::sqrt(ray.x * ray.x + ray.y * ray.y);
    // Detail finer than a pixel would only flicker between the two cameras: it fades with distance.
    const double fine = std::clamp(0.03 * 800 / (distance * distance * 1.5), 0.0, 1.0);
    const double patches = meadow_.octaves(x * 0.22 + 50, y * 0.10 + 50, 4);
    const double tufts = meadow_.octaves(x * 2.4 + 90, y * 1.1, 3, 0.6);
    const double blades = meadow_.octaves(x * 34, y * 7, 2, 0.7);
    Colour colour = mix({0.33, 0.46, 0.17}, {0.68, 0.68, 0.32}, smooth_step(0.25, 0.75, patches));
    const double shade = 1 + 0.42 * (tufts - 0.5) * std::min(1.0, 14 / distance) + 0.75 * (blades - 0.5) * fine;
    colour = scaled(colour, 0.95 * shade);
    return mix(colour, kHaze, 0.22 * smooth_step(15, 90, distance));
  }

  const CameraCalibration& camera_;
  double pixel_;
  ValueNoise clouds_;
  ValueNoise ridge_;
  ValueNoise wood_;
  ValueNoise meadow_;
};

}  // namespace

cv::Mat paint_landscape(const CameraCalibration& camera, std::uint64_t seed) {
  const Landscape landscape(camera, seed);
  cv::Mat picture(static_cast<int>(camera.height), static_cast<int>(camera.width), CV_8UC3);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const Colour c = landscape.colour_at({static_cast<double>(x), static_cast<double>(y)});
      picture.at<cv::Vec3b>(y, x) = {cv::saturate_cast<uchar>(c.blue * 255), cv::saturate_cast<uchar>(c.green * 255),
                                     cv::saturate_cast<uchar>(c.red * 255)};
    }
  }
  return picture;
}

}  // namespace roseau::synthesis
