// What coding pictures costs one core, and how much smaller they become: our PNG with every picture, libpng beside it, JPEG,
// and the way back. CPU time of this thread.
//
// Pictures: a crown of leaves as "dead leaves" (discs that cover each other, radii by the inverse cube from 2 to 60 px, each
// with a gradient, sharp to about 1.2 px), grey values 10 to 230, with a sensor's noise: shot noise of 39 electrons per grey
// value and 8 electrons of read noise (standard deviation 1.6 at grey 100); and the simulated rig's large camera.
#include <png.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "bench/bench.h"
#include "core/image_coding/image_decoder.h"
#include "core/image_coding/jpeg.h"
#include "core/image_coding/png_encoder.h"
#include "synthesis/rig/camera_view.h"

namespace roseau::bench {

namespace {

constexpr int kPictures = 16;  // more than caches hold
constexpr int kRounds = 7;
constexpr double kElectronsPerGrey = 39;
constexpr double kReadNoise_electrons = 8;

using Bytes = std::vector<std::byte>;

struct Pictures {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<Bytes> pixels;

  image::PixelView view(std::size_t index) const {
    return {.pixels = pixels[index % pixels.size()], .width = width, .height = height, .stride = width};
  }
  double megabytes() const { return 1e-6 * static_cast<double>(pixels.size() * pixels.front().size()); }
};

/// Grey values of the leaves without noise.
std::vector<float> dead_leaves(std::uint32_t width, std::uint32_t height, std::mt19937_64& random) {
  constexpr double kSmallest_px = 2;
  constexpr double kLargest_px = 60;
  std::vector<float> grey(std::size_t{width} * height, 60.0F);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto leaves = static_cast<int>(width * height / 40);
  for (int leaf = 0; leaf < leaves; ++leaf) {
    const double share = uniform(random);
    const double inverse_square = 1 / (kSmallest_px * kSmallest_px) * (1 - share) + share / (kLargest_px * kLargest_px);
    const double radius = 1 / std::sqrt(inverse_square);
    const double x0 = uniform(random) * width;
    const double y0 = uniform(random) * height;
    const double value = 10 + 220 * uniform(random) * uniform(random);
    const double slope_x = 20 * (uniform(random) - 0.5) / radius;
    const double slope_y = 20 * (uniform(random) - 0.5) / radius;
    const int left = std::max(0, static_cast<int>(x0 - radius));
    const int right = std::min(static_cast<int>(width) - 1, static_cast<int>(x0 + radius) + 1);
    const int top = std::max(0, static_cast<int>(y0 - radius));
    const int bottom = std::min(static_cast<int>(height) - 1, static_cast<int>(y0 + radius) + 1);
    for (int y = top; y <= bottom; ++y) {
      for (int x = left; x <= right; ++x) {
        if (std::hypot(x - x0, y - y0) > radius) continue;
        const double shade = value + slope_x * (x - x0) + slope_y * (y - y0);
        grey[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)] =
            static_cast<float>(std::clamp(shade, 10.0, 230.0));
      }
    }
  }
  return grey;
}

/// The lens: each pixel with its neighbours, 1 2 1 both ways.
void blur(std::vector<float>& grey, std::uint32_t width) {
  for (const std::size_t step : {std::size_t{1}, std::size_t{width}}) {
    const std::vector<float> sharp = grey;
    for (std::size_t i = step; i + step < grey.size(); ++i) {
      grey[i] = 0.25F * sharp[i - step] + 0.5F * sharp[i] + 0.25F * sharp[i + step];
    }
  }
}

Pictures foliage(std::uint32_t width, std::uint32_t height) {
  std::mt19937_64 random(7);
  auto grey = dead_leaves(width, height, random);
  blur(grey, width);
  std::normal_distribution<float> normal;
  Pictures pictures{.width = width, .height = height};
  for (int i = 0; i < kPictures; ++i) {
    Bytes& pixels = pictures.pixels.emplace_back(grey.size());
    for (std::size_t at = 0; at < grey.size(); ++at) {
      const double variance = grey[at] / kElectronsPerGrey + std::pow(kReadNoise_electrons / kElectronsPerGrey, 2);
      const double value = grey[at] + std::sqrt(variance) * normal(random);
      pixels[at] = static_cast<std::byte>(std::lround(std::clamp(value, 0.0, 255.0)));
    }
  }
  return pictures;
}

Result<Pictures> simulated() {
  auto world = synthesis::World::build(synthesis::large_camera_scene());
  if (!world) return world.error();
  synthesis::CameraView camera(std::move(*world), 0);
  FramePool pool(1, camera.frame_bytes());
  Pictures pictures;
  for (int i = 0; i < kPictures; ++i) {
    const Frame frame = camera.take(static_cast<std::uint64_t>(i), i / camera.camera().rate_hz, pool);
    if (frame.format != PixelFormat::mono8 || frame.stride != frame.width) {
      return Error{ErrorCode::unsupported, "the large camera is not grey"};
    }
    pictures.width = frame.width;
    pictures.height = frame.height;
    pictures.pixels.emplace_back(frame.bytes().begin(), frame.bytes().end());
  }
  return pictures;
}

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Median over the rounds, megabytes of pixels per second; `work` does picture number i.
template <class Work>
Result<double> rate(const Pictures& pictures, int rounds, Work work) {
  std::vector<double> seconds;
  for (int round = 0; round < rounds; ++round) {
    const double before = cpu_seconds();
    for (std::size_t i = 0; i < pictures.pixels.size(); ++i) {
      if (Result<void> done = work(i); !done) return done.error();
    }
    seconds.push_back(cpu_seconds() - before);
  }
  std::ranges::sort(seconds);
  return pictures.megabytes() / seconds[seconds.size() / 2];
}

double ratio(const Pictures& pictures, const std::vector<Bytes>& coded) {
  double bytes = 0;
  for (const Bytes& file : coded) bytes += static_cast<double>(file.size());
  return 1e6 * pictures.megabytes() / bytes;
}

/// libpng at its fastest level, with the filter that it chooses for that.
Result<double> libpng_rate(const Pictures& pictures) {
  constexpr int kLibpngRounds = 3;
  Bytes out(2 * pictures.pixels.front().size());
  return rate(pictures, kLibpngRounds, [&](std::size_t i) -> Result<void> {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = pictures.width;
    image.height = pictures.height;
    image.format = PNG_FORMAT_GRAY;
    image.flags = PNG_IMAGE_FLAG_FAST;
    png_alloc_size_t size = out.size();
    if (png_image_write_to_memory(&image, out.data(), &size, 0, pictures.pixels[i].data(), 0, nullptr) == 0) {
      return Error{ErrorCode::io, std::string("libpng: ") + image.message};
    }
    return {};
  });
}

template <class Encoder>
Result<double> encode_rate(const Pictures& pictures, Encoder& encoder, std::vector<Bytes>& coded) {
  Bytes out(Encoder::buffer_bytes(pictures.width, pictures.height, PixelFormat::mono8));
  coded.assign(pictures.pixels.size(), {});
  return rate(pictures, kRounds, [&](std::size_t i) -> Result<void> {
    const auto size = encoder.encode(pictures.view(i), out);
    if (!size) return size.error();
    if (coded[i].empty()) coded[i].assign(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(*size));
    return {};
  });
}

Result<double> decode_rate(const Pictures& pictures, const std::vector<Bytes>& coded, bool is_lossless) {
  image::ImageDecoder decoder;
  Bytes pixels(pictures.pixels.front().size());
  return rate(pictures, kRounds, [&](std::size_t i) -> Result<void> {
    if (const auto info = decoder.decode(coded[i], pixels); !info) return info.error();
    if (is_lossless && i == 0 && pixels != pictures.pixels[i]) return Error{ErrorCode::corrupt, "not the same pixels"};
    return {};
  });
}

Result<void> add_figures(const Pictures& pictures, const std::string& name, nlohmann::ordered_json& figures) {
  std::vector<Bytes> coded;
  image::PngEncoder png;
  const auto png_rate = encode_rate(pictures, png, coded);
  if (!png_rate) return png_rate.error();
  const auto png_decode_rate = decode_rate(pictures, coded, true);
  if (!png_decode_rate) return png_decode_rate.error();
  figures[name + "_png_megabytes_per_cpu_s"] = *png_rate;
  figures[name + "_png_ratio"] = ratio(pictures, coded);
  figures[name + "_png_decode_megabytes_per_cpu_s"] = *png_decode_rate;
  const auto libpng = libpng_rate(pictures);
  if (!libpng) return libpng.error();
  figures["reference_" + name + "_libpng_megabytes_per_cpu_s"] = *libpng;
  for (const int quality : {95, 85}) {
    image::JpegEncoder jpeg(quality);
    const auto jpeg_rate = encode_rate(pictures, jpeg, coded);
    if (!jpeg_rate) return jpeg_rate.error();
    const auto jpeg_decode_rate = decode_rate(pictures, coded, false);
    if (!jpeg_decode_rate) return jpeg_decode_rate.error();
    const std::string prefix = name + "_jpeg" + std::to_string(quality);
    figures[prefix + "_megabytes_per_cpu_s"] = *jpeg_rate;
    figures[prefix + "_ratio"] = ratio(pictures, coded);
    figures[prefix + "_decode_megabytes_per_cpu_s"] = *jpeg_decode_rate;
  }
  return {};
}

Result<nlohmann::ordered_json> run() {
  nlohmann::ordered_json figures{{"case", "images"}};
  if (auto added = add_figures(foliage(1280, 1024), "foliage_1280x1024", figures); !added) return added.error();
  if (auto added = add_figures(foliage(1920, 1080), "foliage_1920x1080", figures); !added) return added.error();
  const auto rig = simulated();
  if (!rig) return rig.error();
  if (auto added = add_figures(*rig, "rig_1280x1024", figures); !added) return added.error();
  return figures;
}

}  // namespace

void add_image_cases(std::vector<Case>& cases) {
  cases.push_back({"images", "PNG and JPEG of noisy foliage: CPU and ratio, there and back; libpng beside", run});
}

}  // namespace roseau::bench
