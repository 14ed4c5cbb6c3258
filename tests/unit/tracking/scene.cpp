#include "tests/unit/tracking/scene.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace roseau::tracking::testing {

namespace {

/// 1 inside, 0 outside, linear over one pixel at the edge.
double coverage(const ImageRect& shape, const Eigen::Vector2d& at) {
  const double inside =
      std::min({at.x() - shape.x, shape.x + shape.width - at.x(), at.y() - shape.y, shape.y + shape.height - at.y()});
  return std::clamp(inside + 0.5, 0.0, 1.0);
}

}  // namespace

Texture::Texture(std::uint64_t seed, double contrast, int waves) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int i = 0; i < waves; ++i) {
    const double wavelength_px = 5 * std::pow(8.0, uniform(random));
    const double direction = 2 * std::numbers::pi * uniform(random);
    const double k = 2 * std::numbers::pi / wavelength_px;
    const double phase = 2 * std::numbers::pi * uniform(random);
    waves_.push_back({{k * std::cos(direction), k * std::sin(direction)}, phase, contrast * std::sqrt(2.0 / waves)});
  }
}

Eigen::Matrix2d rotation(double angle_rad) {
  Eigen::Matrix2d turn;
  turn << std::cos(angle_rad), -std::sin(angle_rad), std::sin(angle_rad), std::cos(angle_rad);
  return turn;
}

Picture::Picture(int width, int height)
    : width_(width), height_(height), values_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 128.0F) {}

void Picture::draw(const Texture& texture, const Pose& pose, const std::optional<ImageRect>& shape) {
  const Eigen::Matrix2d back = pose.turn.inverse();
  const Eigen::Vector2d origin = pose.centre - back * (pose.centre + pose.shift);  // material of picture point (0, 0)
  std::vector<float> layer(values_.size(), 128.0F);
  std::vector<std::complex<float>> along_x(static_cast<std::size_t>(width_));
  for (const Texture::Wave& wave : texture.waves()) {
    // cos(k m + phase) is a product in x and y for every affine pose.
    const Eigen::Vector2d k = back.transpose() * wave.k;
    const double phase = wave.phase + wave.k.dot(origin);
    for (int x = 0; x < width_; ++x) {
      along_x[static_cast<std::size_t>(x)] = std::complex<float>(std::polar(wave.amplitude, k.x() * (x + 0.5) + phase));
    }
    for (int y = 0; y < height_; ++y) {
      const auto along_y = std::complex<float>(std::polar(1.0, k.y() * (y + 0.5)));
      float* row = layer.data() + index(0, y);
      for (std::size_t x = 0; x < along_x.size(); ++x) {
        row[x] += along_x[x].real() * along_y.real() - along_x[x].imag() * along_y.imag();
      }
    }
  }
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const std::size_t at = index(x, y);
      const double share = shape ? coverage(*shape, origin + back * Eigen::Vector2d(x + 0.5, y + 0.5)) : 1.0;
      values_[at] += static_cast<float>(share) * (layer[at] - values_[at]);
    }
  }
}

void Picture::scale_light(double gain, double offset) {
  for (float& value : values_) value = static_cast<float>(gain * value + offset);
}

void Picture::mix(const Picture& other, double share) {
  for (std::size_t i = 0; i < values_.size(); ++i) values_[i] += static_cast<float>(share) * (other.values_[i] - values_[i]);
}

void Picture::add_noise(double sd, std::mt19937_64& random) {
  std::normal_distribution<float> noise(0.0F, static_cast<float>(sd));
  for (float& value : values_) value += noise(random);
}

std::uint8_t Picture::pixel(int x, int y) const {
  return static_cast<std::uint8_t>(std::clamp(std::lround(value(x, y)), 0L, 255L));
}

Frame frame_of(const Picture& picture) {
  Frame frame;
  frame.width = static_cast<std::uint32_t>(picture.width());
  frame.height = static_cast<std::uint32_t>(picture.height());
  frame.stride = frame.width + 24;
  FramePool pool(1, std::size_t{frame.stride} * frame.height);
  frame.pixels = pool.acquire();
  const auto bytes = frame.pixels.writable_bytes();
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      bytes[static_cast<std::size_t>(y) * frame.stride + static_cast<std::size_t>(x)] = std::byte{picture.pixel(x, y)};
    }
  }
  return frame;
}

Sample sample_of(Frame frame, StreamId stream, int index) {
  SampleHeader header;
  header.stream = stream;
  header.sequence = static_cast<std::uint32_t>(index);
  header.sample_time = host_time_from_ns(1'000'000'000 + static_cast<std::int64_t>(index) * 33'333'333);
  header.arrival_time = header.sample_time + std::chrono::milliseconds(20);
  return {header, std::move(frame)};
}

}  // namespace roseau::tracking::testing
