#include <fmt/format.h>

#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "drivers/camera/file/plugin_interface.h"
#include "drivers/camera/file/video_writer.h"

namespace roseau::camera {

namespace {

class OpencvVideoWriter : public VideoWriter {
 public:
  explicit OpencvVideoWriter(VideoWriterOptions options) : options_(std::move(options)) {}

  Result<void> open() override {
    const std::string extension = std::filesystem::path(options_.path).extension().string();
    int codec = 0;
    if (extension == ".mkv") {
      codec = cv::VideoWriter::fourcc('F', 'F', 'V', '1');
    } else if (extension == ".mp4") {
      codec = cv::VideoWriter::fourcc('m', 'p', '4', 'v');
    } else if (extension == ".avi") {
      codec = cv::VideoWriter::fourcc('X', 'V', 'I', 'D');
    } else {
      return Error{ErrorCode::invalid_argument,
                   fmt::format("video '{}': name it .mkv (lossless), .mp4 or .avi", options_.path)};
    }
    const cv::Size size(static_cast<int>(options_.width), static_cast<int>(options_.height));
    return guarded([&]() -> Result<void> {
      if (writer_.open(options_.path, cv::CAP_FFMPEG, codec, options_.rate_hz, size, true)) return {};
      return Error{ErrorCode::io, fmt::format("video '{}' cannot be made: can its directory be written, and does this "
                                              "machine's FFmpeg have the codec?",
                                              options_.path)};
    });
  }

  Result<void> write(std::span<const std::byte> pixels, std::uint32_t stride, PixelFormat format) override {
    return guarded([&]() -> Result<void> {
      const auto rows = static_cast<int>(options_.height);
      const auto columns = static_cast<int>(options_.width);
      const int type = format == PixelFormat::mono8 ? CV_8UC1 : format == PixelFormat::mono16 ? CV_16UC1 : CV_8UC3;
      // OpenCV takes no pointer to constant memory; nothing is written to it.
      auto* data = const_cast<std::byte*>(pixels.data());
      cv::Mat picture(rows, columns, type, data, stride);
      if (format == PixelFormat::mono16) {
        picture.convertTo(narrow_, CV_8U, 1.0 / 256);
        picture = narrow_;
      }
      if (format == PixelFormat::mono8 || format == PixelFormat::mono16) {
        cv::cvtColor(picture, colour_, cv::COLOR_GRAY2BGR);
        picture = colour_;
      } else if (format == PixelFormat::rgb8) {
        cv::cvtColor(picture, colour_, cv::COLOR_RGB2BGR);
        picture = colour_;
      }
      writer_.write(picture);
      return {};
    });
  }

  Result<void> close() override {
    return guarded([&]() -> Result<void> {
      writer_.release();
      std::error_code error;
      if (std::filesystem::file_size(options_.path, error) > 0 && !error) return {};
      return Error{ErrorCode::io, fmt::format("video '{}' could not be written: is the disk full?", options_.path)};
    });
  }

 private:
  template <class Function>
  Result<void> guarded(const Function& function) const {
    try {
      return function();
    } catch (const std::exception& error) {
      return Error{ErrorCode::io, fmt::format("video '{}' cannot be written: {}", options_.path, error.what())};
    }
  }

  VideoWriterOptions options_;
  cv::VideoWriter writer_;
  cv::Mat narrow_;
  cv::Mat colour_;
};

}  // namespace

}  // namespace roseau::camera

extern "C" __attribute__((visibility("default"))) roseau::camera::VideoWriter* roseau_video_plugin_make_writer(
    const roseau::camera::VideoWriterOptions& options) {
  return new roseau::camera::OpencvVideoWriter(options);
}
