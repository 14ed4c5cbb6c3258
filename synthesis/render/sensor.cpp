#include "synthesis/render/sensor.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace roseau::render {

namespace {

constexpr std::size_t kTableSize = 1 << 16U;
constexpr int kUnit = 32;           // 127 / 32: numbers beyond 4 standard deviations are clipped there
constexpr float kToNearest = 0.5F;  // before what is positive is cut off
constexpr std::uint64_t kTableStream = 301;
constexpr std::uint64_t kOffsetStream = 302;

// Weights of a sampled Gaussian that add up to 1: the centre's, then one side's.
std::vector<std::uint16_t> gaussian_weights(double sd_px) {
  if (sd_px < 0.05) return {65535};
  const int reach = static_cast<int>(std::ceil(3.2 * sd_px));
  std::vector<double> exact;
  double sum = 0;
  for (int i = 0; i <= reach; ++i) {
    exact.push_back(std::exp(-0.5 * i * i / (sd_px * sd_px)));
    sum += i == 0 ? exact.back() : 2 * exact.back();
  }
  std::vector<std::uint16_t> weights;
  long left = 65536;
  for (int i = reach; i > 0; --i) {
    weights.insert(weights.begin(), static_cast<std::uint16_t>(std::lround(65536 * exact[static_cast<std::size_t>(i)] / sum)));
    left -= 2 * weights.front();
  }
  weights.insert(weights.begin(), static_cast<std::uint16_t>(std::min(left, 65535L)));
  return weights;
}

std::uint16_t weighted(unsigned value, unsigned weight) { return static_cast<std::uint16_t>((value * weight) >> 16U); }

}  // namespace

Sensor::Sensor(const CameraOptions& options, int width, int height, int channels)
    : gain_(options.gain),
      weights_(gaussian_weights(options.lens_blur_px)),
      channels_(static_cast<std::size_t>(channels)),
      offsets_(options.noise_seed, kOffsetStream) {
  ROSEAU_CHECK(width > 0 && height > 0);
  const std::size_t row_size = static_cast<std::size_t>(width) * channels_;
  padding_ = (weights_.size() - 1) * channels_;
  row_.resize(row_size + 2 * padding_);
  light_.resize(row_size);
  gauss_.resize(kTableSize + row_size);
  const RandomStream normals(options.noise_seed, kTableStream);
  for (std::size_t i = 0; i < gauss_.size(); ++i) {
    gauss_[i] = static_cast<std::int8_t>(std::clamp<long>(std::lround(kUnit * normals.normal(i)), -127, 127));
  }
  const double read_noise_steps = options.read_noise_counts * gain_ * kStepsPerCount;
  dark_variance_ = static_cast<float>(read_noise_steps * read_noise_steps);
  variance_per_step_ = static_cast<float>(options.shot_noise_gain * gain_ * kStepsPerCount);
  silent_ = dark_variance_ == 0 && variance_per_step_ == 0;
}

// The edge rows and columns stand for what lies beyond them.
void Sensor::blur_down(const Picture& picture, int y) {
  const std::size_t size = picture.row_size();
  const std::uint16_t* centre = picture.row(y);
  std::uint16_t* out = row_.data() + padding_;
  if (weights_.size() == 1) {
    std::copy_n(centre, size, out);
    return;
  }
  for (std::size_t i = 0; i < size; ++i) out[i] = weighted(centre[i], weights_[0]);
  for (std::size_t tap = 1; tap < weights_.size(); ++tap) {
    const std::uint16_t* above = picture.row(std::max(y - static_cast<int>(tap), 0));
    const std::uint16_t* below = picture.row(std::min(y + static_cast<int>(tap), picture.height - 1));
    const unsigned weight = weights_[tap];
    for (std::size_t i = 0; i < size; ++i) {
      out[i] = static_cast<std::uint16_t>(out[i] + weighted(static_cast<std::uint16_t>(above[i] + below[i]), weight));
    }
  }
}

void Sensor::blur_across() {
  const std::size_t size = light_.size();
  const std::uint16_t* row = row_.data() + padding_;
  if (weights_.size() == 1) {
    std::copy_n(row, size, light_.begin());
    return;
  }
  for (std::size_t i = 0; i < padding_; ++i) {
    row_[padding_ - 1 - i] = row_[2 * padding_ < size ? padding_ + (channels_ - 1 - i % channels_) : padding_];
    row_[padding_ + size + i] = row_[padding_ + size - channels_ + i % channels_];
  }
  std::uint16_t* out = light_.data();
  for (std::size_t i = 0; i < size; ++i) out[i] = weighted(row[i], weights_[0]);
  for (std::size_t tap = 1; tap < weights_.size(); ++tap) {
    const std::uint16_t* left = row - tap * channels_;
    const std::uint16_t* right = row + tap * channels_;
    const unsigned weight = weights_[tap];
    for (std::size_t i = 0; i < size; ++i) {
      out[i] = static_cast<std::uint16_t>(out[i] + weighted(static_cast<std::uint16_t>(left[i] + right[i]), weight));
    }
  }
}

// The loops here and above are plain enough for the compiler to do several pixels at once.
void Sensor::add_noise(std::uint64_t frame, int y, float scale, float offset, std::uint8_t* out) const {
  const std::int8_t* gauss = gauss_.data() + offsets_.bits((frame << 16U) + static_cast<std::uint64_t>(y)) % kTableSize;
  const std::uint16_t* light = light_.data();
  const std::size_t size = light_.size();
  for (std::size_t i = 0; i < size; ++i) {
    const float signal = static_cast<float>(light[i]) * scale + offset;
    const float sd = std::sqrt(dark_variance_ + variance_per_step_ * signal);
    const float noisy = (signal + static_cast<float>(gauss[i]) * sd * (1.0F / kUnit)) * (1.0F / kStepsPerCount);
    // Below zero this rounds upwards; nothing is left of that anyway.
    const int counts = static_cast<int>(noisy + kToNearest);
    out[i] = static_cast<std::uint8_t>(counts < 0 ? 0 : (counts > 255 ? 255 : counts));
  }
}

void Sensor::digitise(double light, std::uint64_t frame, int y, std::span<std::byte> row) const {
  // Each multiplication of the blur, down and across, cut off half a step on average.
  const float lost = weights_.size() == 1 ? 0.0F : static_cast<float>(weights_.size());
  const auto scale = static_cast<float>(light * gain_);
  auto* out = reinterpret_cast<std::uint8_t*>(row.data());
  if (!silent_) {
    add_noise(frame, y, scale, scale * lost, out);
    return;
  }
  for (std::size_t i = 0; i < light_.size(); ++i) {
    const int counts = static_cast<int>((static_cast<float>(light_[i]) + lost) * scale * (1.0F / kStepsPerCount) + kToNearest);
    out[i] = static_cast<std::uint8_t>(counts > 255 ? 255 : counts);
  }
}

void Sensor::read_out(const Picture& picture, double light, std::uint64_t frame, std::span<std::byte> pixels) {
  const std::size_t row_size = picture.row_size();
  ROSEAU_CHECK(pixels.size() >= row_size * static_cast<std::size_t>(picture.height) && row_size == light_.size());
  for (int y = 0; y < picture.height; ++y) {
    blur_down(picture, y);
    blur_across();
    digitise(light, frame, y, pixels.subspan(static_cast<std::size_t>(y) * row_size, row_size));
  }
}

}  // namespace roseau::render
