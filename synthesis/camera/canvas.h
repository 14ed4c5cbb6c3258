// Canvas: drawing on a vertical plane of the world that faces south, in metres (x to the east, z up). What is drawn becomes a
// Layer, a picture with transparency that any camera can see.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "core/geometry.h"
#include "synthesis/random.h"

namespace roseau::synthesis {

/// 0..1 each, as displayed (not linear light).
struct Colour {
  double red = 0;
  double green = 0;
  double blue = 0;
};

inline Colour mix(const Colour& a, const Colour& b, double share_of_b) {
  return {a.red + share_of_b * (b.red - a.red), a.green + share_of_b * (b.green - a.green),
          a.blue + share_of_b * (b.blue - a.blue)};
}

inline Colour scaled(const Colour& a, double factor) { return {a.red * factor, a.green * factor, a.blue * factor}; }

/// A rectangle of the plane.
struct PlaneWindow {
  double left_m = 0;
  double right_m = 0;
  double bottom_m = 0;
  double top_m = 0;
};

/// CV_8UC4: blue, green, red, opacity; colours premultiplied by opacity.
struct Layer {
  cv::Mat pixels;
  double px_per_m = 0;
  double plane_y_m = 0;
  PlaneWindow window;

  /// Texture coordinates (pixel centres at whole numbers) of a point of the plane.
  Vec2 texture_point(double x_m, double z_m) const {
    return {(x_m - window.left_m) * px_per_m - 0.5, (window.top_m - z_m) * px_per_m - 0.5};
  }
};

class Canvas {
 public:
  Canvas(const PlaneWindow& window, double plane_y_m, double px_per_m);

  /// Later shapes lie over earlier ones.
  void polygon(std::span<const Vec2> corners_m, const Colour& colour);
  void disc(Vec2 centre_m, double radius_m, const Colour& colour);
  /// A straight piece of varying width; cut straight at its beginning, round at its end.
  void stroke(Vec2 from_m, Vec2 to_m, double from_width_m, double to_width_m, const Colour& colour);

  /// The finished layer, blurred by a Gaussian of this standard deviation in the layer's pixels (0: not).
  Layer finish(double blur_px) const;

 private:
  cv::Point fixed_point(const Vec2& point_m) const;

  PlaneWindow window_;
  double plane_y_m_;
  double px_per_m_;
  cv::Mat pixels_;  // kOversampling times finer than the layer
};

/// Random numbers in a row, for drawing.
class Dice {
 public:
  Dice(std::uint64_t seed, std::uint64_t stream) : random_(seed, stream) {}
  double between(double low, double high) { return random_.uniform(next_++, low, high); }
  double normal() { return random_.normal(kNormals + next_++); }

 private:
  static constexpr std::uint64_t kNormals = std::uint64_t{1} << 40U;  // far from the uniform numbers' indices
  RandomStream random_;
  std::uint64_t next_ = 0;
};

}  // namespace roseau::synthesis
