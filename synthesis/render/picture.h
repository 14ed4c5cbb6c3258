// The picture while it is being drawn: light per pixel and channel, linear, in steps of 1/64 count.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/frame.h"
#include "synthesis/render/colour.h"

namespace roseau::render {

inline constexpr int kStepsPerCount = 64;
inline constexpr int kMostSteps = 511 * kStepsPerCount;  // twice full scale: what shines brighter than that is cut off there

/// Colours in the channels of a picture, in steps; one that is grey uses the first only.
using Ink = std::array<float, 3>;

/// How colours become channels.
class InkMaker {
 public:
  explicit InkMaker(PixelFormat format) : format_(format) {}

  Ink operator()(const Colour& colour) const {
    constexpr float kScale = 255.0F * kStepsPerCount;
    const auto red = static_cast<float>(colour.red) * kScale;
    const auto green = static_cast<float>(colour.green) * kScale;
    const auto blue = static_cast<float>(colour.blue) * kScale;
    if (format_ == PixelFormat::rgb8) return {red, green, blue};
    if (format_ == PixelFormat::bgr8) return {blue, green, red};
    const float luma = 0.299F * red + 0.587F * green + 0.114F * blue;  // as in JPEG and OpenCV
    return {luma, luma, luma};
  }
  int channels() const { return format_ == PixelFormat::mono8 ? 1 : 3; }

 private:
  PixelFormat format_;
};

inline std::uint16_t to_steps(float value) {
  return static_cast<std::uint16_t>(std::clamp(value, 0.0F, static_cast<float>(kMostSteps)));
}

struct Picture {
  int width = 0;
  int height = 0;
  int channels = 0;
  std::vector<std::uint16_t> steps;  // rows from the top, channels of a pixel side by side

  Picture() = default;
  Picture(int its_width, int its_height, int its_channels)
      : width(its_width),
        height(its_height),
        channels(its_channels),
        steps(static_cast<std::size_t>(its_width) * static_cast<std::size_t>(its_height) *
              static_cast<std::size_t>(its_channels)) {}

  std::size_t row_size() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(channels); }
  std::uint16_t* row(int y) { return steps.data() + static_cast<std::size_t>(y) * row_size(); }
  const std::uint16_t* row(int y) const { return steps.data() + static_cast<std::size_t>(y) * row_size(); }
};

}  // namespace roseau::render
