#include "synthesis/render/sensor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace roseau::render {
namespace {

Picture plain(int width, int height, int channels, double counts) {
  Picture picture(width, height, channels);
  for (std::uint16_t& step : picture.steps) step = static_cast<std::uint16_t>(std::lround(counts * kStepsPerCount));
  return picture;
}

std::vector<std::byte> read_out(const Picture& picture, const CameraOptions& options, double light = 1,
                                std::uint64_t frame = 0) {
  Sensor sensor(options, picture.width, picture.height, picture.channels);
  std::vector<std::byte> pixels(picture.steps.size());
  sensor.read_out(picture, light, frame, pixels);
  return pixels;
}

struct Statistics {
  double mean = 0;
  double variance = 0;
};

Statistics statistics(const std::vector<std::byte>& pixels) {
  Statistics result;
  for (const std::byte pixel : pixels) result.mean += static_cast<double>(pixel) / static_cast<double>(pixels.size());
  for (const std::byte pixel : pixels) {
    result.variance += std::pow(static_cast<double>(pixel) - result.mean, 2) / static_cast<double>(pixels.size());
  }
  return result;
}

constexpr double kRounding = 1.0 / 12;  // variance that whole counts add

TEST(Sensor, NoiseHasTheVarianceItShould) {
  CameraOptions options;
  options.lens_blur_px = 0.7;
  options.read_noise_counts = 1.5;
  options.shot_noise_gain = 0.04;
  for (const double counts : {20.0, 90.3, 180.0}) {
    const Statistics measured = statistics(read_out(plain(400, 400, 1, counts), options));
    EXPECT_NEAR(measured.mean, counts, 0.06);
    EXPECT_NEAR(measured.variance, 1.5 * 1.5 + 0.04 * counts + kRounding, 0.03 * (2.25 + 0.04 * counts)) << counts;
  }
}

TEST(Sensor, GainAndLightScaleThePictureAndGainItsNoise) {
  CameraOptions options;
  options.read_noise_counts = 1;
  options.shot_noise_gain = 0.02;
  options.gain = 2;
  const Statistics measured = statistics(read_out(plain(400, 400, 1, 60), options, 1.25));
  EXPECT_NEAR(measured.mean, 150, 0.1);
  EXPECT_NEAR(measured.variance, 4 + 0.02 * 2 * 150 + kRounding, 0.3);
}

TEST(Sensor, WithoutNoiseRoundsAndCutsOff) {
  CameraOptions options;
  options.read_noise_counts = options.shot_noise_gain = options.lens_blur_px = 0;
  EXPECT_EQ(read_out(plain(16, 16, 3, 99.4), options)[5], std::byte{99});
  EXPECT_EQ(read_out(plain(16, 16, 3, 99.6), options)[5], std::byte{100});
  EXPECT_EQ(read_out(plain(16, 16, 3, 400), options)[5], std::byte{255});
  EXPECT_EQ(read_out(plain(16, 16, 1, 400), options, 0.5)[5], std::byte{200});
}

TEST(Sensor, NoiseIsAFunctionOfSeedAndFrame) {
  const CameraOptions options{.noise_seed = 3};
  const CameraOptions other{.noise_seed = 4};
  const Picture picture = plain(64, 64, 3, 100);
  EXPECT_EQ(read_out(picture, options, 1, 7), read_out(picture, options, 1, 7));
  EXPECT_NE(read_out(picture, options, 1, 7), read_out(picture, options, 1, 8));
  EXPECT_NE(read_out(picture, options, 1, 7), read_out(picture, other, 1, 7));
}

// Neighbours in space, rows and frames have nothing in common.
TEST(Sensor, NoiseIsWhite) {
  const CameraOptions options{.lens_blur_px = 0, .read_noise_counts = 3, .shot_noise_gain = 0};
  const Picture picture = plain(512, 256, 1, 128);
  Sensor sensor(options, 512, 256, 1);
  std::vector<std::byte> one(picture.steps.size());
  std::vector<std::byte> next(picture.steps.size());
  sensor.read_out(picture, 1, 0, one);
  sensor.read_out(picture, 1, 1, next);
  const auto correlation = [](const std::vector<std::byte>& a, const std::vector<std::byte>& b, std::size_t lag) {
    double sum = 0;
    for (std::size_t i = 0; i + lag < a.size(); ++i) {
      sum += (static_cast<double>(a[i]) - 128) * (static_cast<double>(b[i + lag]) - 128);
    }
    return sum / static_cast<double>(a.size() - lag) / 9;
  };
  for (const std::size_t lag : {1U, 2U, 512U, 1024U}) EXPECT_NEAR(correlation(one, one, lag), 0, 0.015) << lag;
  EXPECT_NEAR(correlation(one, next, 0), 0, 0.015);
}

// A line of light becomes a Gaussian of the lens's width, with all of its light, in its own channel only.
TEST(Sensor, BlursByTheLensesPointSpread) {
  for (const double sd_px : {0.6, 1.3, 3.0}) {
    const CameraOptions options{.lens_blur_px = sd_px, .read_noise_counts = 0, .shot_noise_gain = 0};
    for (const bool upright : {true, false}) {
      Picture picture(48, 48, 3);
      for (int i = 0; i < 48; ++i) {
        picture.row(upright ? i : 25)[static_cast<std::size_t>(upright ? 25 : i) * 3 + 1] = 250 * kStepsPerCount;
      }
      const std::vector<std::byte> pixels = read_out(picture, options);
      double sum = 0;
      double second = 0;
      for (std::size_t i = 0; i < 48; ++i) {
        const std::size_t pixel = upright ? 48 * 20 + i : 48 * i + 20;
        EXPECT_EQ(pixels[3 * pixel], std::byte{0});
        EXPECT_EQ(pixels[3 * pixel + 2], std::byte{0});
        const auto value = static_cast<double>(pixels[3 * pixel + 1]);
        sum += value;
        second += value * std::pow(static_cast<double>(i) - 25, 2);
      }
      EXPECT_NEAR(sum, 250, 4) << sd_px;
      EXPECT_NEAR(std::sqrt(second / sum), sd_px, 0.04 * sd_px) << sd_px;
    }
  }
}

TEST(Sensor, EdgesOfThePictureStandForWhatLiesBeyond) {
  const CameraOptions options{.lens_blur_px = 2, .read_noise_counts = 0, .shot_noise_gain = 0};
  Picture picture = plain(32, 32, 3, 0);
  for (std::size_t i = 0; i < picture.steps.size(); ++i)
    picture.steps[i] = static_cast<std::uint16_t>((i % 3 + 1) * 50 * kStepsPerCount);
  const std::vector<std::byte> pixels = read_out(picture, options);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    ASSERT_NEAR(static_cast<double>(pixels[i]), static_cast<double>((i % 3 + 1) * 50), 1) << i;
}

}  // namespace
}  // namespace roseau::render
