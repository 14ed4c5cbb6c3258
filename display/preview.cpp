#include "display/preview.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <vector>

#include "core/image_coding/jpeg.h"

namespace roseau::display {

struct PreviewEncoder::State {
  std::uint32_t max_width_px;
  image::JpegEncoder encoder;
  std::vector<std::byte> jpeg;  // kept between pictures
  cv::Mat eight_bit;
  cv::Mat scaled;
};

namespace {

cv::Mat view_of(const Frame& frame) {
  const auto channels = static_cast<int>(bytes_per_pixel(frame.format) / (frame.format == PixelFormat::mono16 ? 2 : 1));
  const int type = CV_MAKETYPE(frame.format == PixelFormat::mono16 ? CV_16U : CV_8U, channels);
  // OpenCV has no view of constant pixels; nothing below writes to it.
  auto* pixels = const_cast<std::byte*>(frame.bytes().data());
  return {static_cast<int>(frame.height), static_cast<int>(frame.width), type, pixels, frame.stride};
}

/// The picture with whole rows from `picture`, as the encoder takes it.
image::PixelView pixels_of(const cv::Mat& picture, PixelFormat format) {
  const auto height = static_cast<std::size_t>(picture.rows);
  return {.pixels = std::as_bytes(std::span(picture.data, picture.step[0] * (height - 1) + picture.cols * picture.elemSize())),
          .width = static_cast<std::uint32_t>(picture.cols),
          .height = static_cast<std::uint32_t>(height),
          .stride = static_cast<std::uint32_t>(picture.step[0]),
          .format = format};
}

}  // namespace

PreviewEncoder::PreviewEncoder(std::uint32_t max_width_px, int quality)
    : state_(new State{.max_width_px = max_width_px,
                       .encoder = image::JpegEncoder(quality, image::JpegEncoder::Transform::fast)}) {}

PreviewEncoder::~PreviewEncoder() = default;

Result<std::string_view> PreviewEncoder::encode(const Frame& frame) {
  if (frame.width == 0 || frame.height == 0) return Error{ErrorCode::invalid_argument, "the picture is empty"};
  try {
    cv::Mat picture = view_of(frame);
    if (frame.width > state_->max_width_px) {
      const double scale = static_cast<double>(state_->max_width_px) / frame.width;
      const cv::Size size(static_cast<int>(state_->max_width_px), std::max(1, cvRound(frame.height * scale)));
      cv::resize(picture, state_->scaled, size, 0, 0, cv::INTER_AREA);
      picture = state_->scaled;
    }
    if (frame.format == PixelFormat::mono16) {
      constexpr double kUpperByte = 1.0 / 256;
      picture.convertTo(state_->eight_bit, CV_8U, kUpperByte);
      picture = state_->eight_bit;
    }
    const PixelFormat format = frame.format == PixelFormat::mono16 ? PixelFormat::mono8 : frame.format;
    const auto view = pixels_of(picture, format);
    state_->jpeg.resize(image::JpegEncoder::buffer_bytes(view.width, view.height, format));
    const auto size = state_->encoder.encode(view, state_->jpeg);
    if (!size) return size.error();
    return std::string_view(reinterpret_cast<const char*>(state_->jpeg.data()), *size);
  } catch (const cv::Exception& error) {
    return Error{ErrorCode::io, std::string("scaling the picture: ") + error.what()};
  }
}

}  // namespace roseau::display
