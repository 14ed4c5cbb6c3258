#include "tracking/gray.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace roseau::tracking {

namespace {

int bits_that_hold(const cv::Mat& words) {
  double brightest = 0;
  cv::minMaxLoc(words, nullptr, &brightest);
  for (const int bits : {10, 12, 14}) {
    if (brightest < (1 << bits)) return bits;
  }
  return 16;
}

}  // namespace

Result<cv::Mat> GrayConverter::convert(const Frame& frame, cv::Mat& storage) {
  const std::size_t row_bytes = frame.width * bytes_per_pixel(frame.format);
  if (frame.width == 0 || frame.height == 0 || !frame.pixels || frame.stride < row_bytes ||
      frame.pixels.bytes().size() < std::size_t{frame.stride} * frame.height) {
    return Error{ErrorCode::corrupt, fmt::format("a frame of {}x{} {} with rows of {} bytes holds too few bytes", frame.width,
                                                 frame.height, to_string(frame.format), frame.stride)};
  }
  // OpenCV has no read-only view; nothing below writes through this one.
  auto* pixels = const_cast<std::byte*>(frame.pixels.bytes().data());  // NOLINT(cppcoreguidelines-pro-type-const-cast)
  const auto view = [&](int type) {
    return cv::Mat(static_cast<int>(frame.height), static_cast<int>(frame.width), type, pixels, frame.stride);
  };
  switch (frame.format) {
    case PixelFormat::mono8:
      return view(CV_8UC1);
    case PixelFormat::mono16: {
      const cv::Mat words = view(CV_16UC1);
      if (mono16_bits_ == 0) mono16_bits_ = bits_that_hold(words);
      words.convertTo(storage, CV_8U, 1.0 / (1 << (mono16_bits_ - 8)));
      return storage;
    }
    case PixelFormat::bgr8:
      cv::cvtColor(view(CV_8UC3), storage, cv::COLOR_BGR2GRAY);
      return storage;
    case PixelFormat::rgb8:
      cv::cvtColor(view(CV_8UC3), storage, cv::COLOR_RGB2GRAY);
      return storage;
  }
  return Error{ErrorCode::unsupported, "a frame in a pixel format that tracking does not know"};
}

}  // namespace roseau::tracking
