// Pictures with exactly known motion: textures are sums of cosines, evaluated where each pixel looks, so that any sub-pixel
// displacement is rendered without interpolation.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "core/frame.h"
#include "core/sample.h"

namespace roseau::tracking::testing {

/// Mean 128, standard deviation `contrast` grey levels; wavelengths from 5 to 40 px, no direction preferred.
class Texture {
 public:
  explicit Texture(std::uint64_t seed, double contrast = 30, int waves = 60);
  struct Wave {
    Eigen::Vector2d k;  // rad/px
    double phase;
    double amplitude;
  };
  const std::vector<Wave>& waves() const { return waves_; }

 private:
  std::vector<Wave> waves_;
};

/// Where material points are in the picture: p = centre + turn (m - centre) + shift. Pixel centres are at x + 0.5.
struct Pose {
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  Eigen::Matrix2d turn = Eigen::Matrix2d::Identity();
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
};
Eigen::Matrix2d rotation(double angle_rad);

class Picture {
 public:
  Picture(int width, int height);
  /// Over everything that is there; `shape` limits it to a rectangle of the material, with edges soft over one pixel.
  void draw(const Texture& texture, const Pose& pose, const std::optional<ImageRect>& shape = std::nullopt);
  void scale_light(double gain, double offset);
  void mix(const Picture& other, double share);
  void add_noise(double sd, std::mt19937_64& random);

  int width() const { return width_; }
  int height() const { return height_; }
  std::uint8_t pixel(int x, int y) const;
  float value(int x, int y) const { return values_[index(x, y)]; }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }

  int width_;
  int height_;
  std::vector<float> values_;
};

/// A mono8 frame of this picture with some bytes between the rows.
Frame frame_of(const Picture& picture);

/// A sample of stream `stream`, `index` frame times of 1/30 s after the start.
Sample sample_of(Frame frame, StreamId stream, int index);

}  // namespace roseau::tracking::testing
