#include "display/preview.h"

#include <turbojpeg.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

namespace roseau::display {

struct PreviewEncoder::State {
  std::uint32_t max_width_px;
  int quality;
  tjhandle compressor = tjInitCompress();
  unsigned char* jpeg = nullptr;  // grown by libjpeg-turbo, kept between pictures
  unsigned long capacity_bytes = 0;
  cv::Mat eight_bit;
  cv::Mat scaled;

  State(std::uint32_t width_px, int jpeg_quality) : max_width_px(width_px), quality(jpeg_quality) {}
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    tjFree(jpeg);
    if (compressor != nullptr) tjDestroy(compressor);
  }
};

namespace {

cv::Mat view_of(const Frame& frame) {
  const auto channels = static_cast<int>(bytes_per_pixel(frame.format) / (frame.format == PixelFormat::mono16 ? 2 : 1));
  const int type = CV_MAKETYPE(frame.format == PixelFormat::mono16 ? CV_16U : CV_8U, channels);
  // OpenCV has no view of constant pixels; nothing below writes to it.
  auto* pixels = const_cast<std::byte*>(frame.bytes().data());
  return {static_cast<int>(frame.height), static_cast<int>(frame.width), type, pixels, frame.stride};
}

TJPF turbo_format(PixelFormat format) {
  switch (format) {
    case PixelFormat::bgr8:
      return TJPF_BGR;
    case PixelFormat::rgb8:
      return TJPF_RGB;
    case PixelFormat::mono8:
    case PixelFormat::mono16:
      break;
  }
  return TJPF_GRAY;
}

}  // namespace

PreviewEncoder::PreviewEncoder(std::uint32_t max_width_px, int quality)
    : state_(std::make_unique<State>(max_width_px, quality)) {}

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
    const TJPF format = turbo_format(frame.format);
    const TJSAMP subsampling = format == TJPF_GRAY ? TJSAMP_GRAY : TJSAMP_420;
    unsigned long size_bytes = state_->capacity_bytes;
    if (tjCompress2(state_->compressor, picture.data, picture.cols, static_cast<int>(picture.step[0]), picture.rows, format,
                    &state_->jpeg, &size_bytes, subsampling, state_->quality, TJFLAG_FASTDCT) != 0) {
      return Error{ErrorCode::io, std::string("JPEG: ") + tjGetErrorStr2(state_->compressor)};
    }
    state_->capacity_bytes = std::max(state_->capacity_bytes, size_bytes);
    return std::string_view(reinterpret_cast<const char*>(state_->jpeg), size_bytes);
  } catch (const cv::Exception& error) {
    return Error{ErrorCode::io, std::string("scaling the picture: ") + error.what()};
  }
}

}  // namespace roseau::display
