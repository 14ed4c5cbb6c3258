// Sensor: the last stage of a picture: the lens's blur, gain, shot and read noise, and the step to 8 bits. The noise of a
// frame is a function of (seed, frame number): frames can be made in any order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/random.h"
#include "synthesis/render/camera_options.h"
#include "synthesis/render/picture.h"

namespace roseau::render {

class Sensor {
 public:
  Sensor(const CameraOptions& options, int width, int height, int channels);

  /// Reads the picture out as 8-bit rows without padding. `light`: factor on everything in the picture.
  void read_out(const Picture& picture, double light, std::uint64_t frame, std::span<std::byte> pixels);

 private:
  void blur_down(const Picture& picture, int y);
  void blur_across();
  void digitise(double light, std::uint64_t frame, int y, std::span<std::byte> row) const;
  void add_noise(std::uint64_t frame, int y, float scale, float offset, std::uint8_t* out) const;

  double gain_;
  std::vector<std::uint16_t> weights_;  // of the blur, 1/65536: the centre's, then one side's
  std::size_t channels_;
  std::size_t padding_ = 0;           // of a row, at each end
  std::vector<std::uint16_t> row_;    // blurred down the columns, padded
  std::vector<std::uint16_t> light_;  // blurred
  RandomStream offsets_;
  // Gaussian numbers, kUnit to one standard deviation. Each row of each frame starts at a random place of the table: far
  // cheaper than a number per pixel, and no two frames are alike.
  std::vector<std::int8_t> gauss_;
  // Variance of the noise, in steps squared: at no signal, and per step of signal.
  float dark_variance_ = 0;
  float variance_per_step_ = 0;
  bool silent_ = false;
};

}  // namespace roseau::render
