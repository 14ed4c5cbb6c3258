// A video file being written. The coder lives in the same plug-in as the decoder (video_file.h), loaded when the first video is
// made.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/frame.h"
#include "core/result.h"

namespace roseau::camera {

struct VideoWriterOptions {
  std::string path;  // .mkv: lossless (FFV1); .mp4, .avi: MPEG-4. An existing file is overwritten: ask before
  double rate_hz = 25;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};

/// One thread at a time.
class VideoWriter {
 public:
  virtual ~VideoWriter() = default;
  virtual Result<void> open() = 0;
  /// Rows `stride` bytes apart; the size is that of the options. mono16 keeps its upper eight bits.
  virtual Result<void> write(std::span<const std::byte> pixels, std::uint32_t stride, PixelFormat format) = 0;
  /// Error: the file is empty, as when no byte of it could be written.
  virtual Result<void> close() = 0;
};

/// Error: the plug-in is not there, or belongs to another version of the program.
Result<std::unique_ptr<VideoWriter>> make_video_writer(const VideoWriterOptions& options);

}  // namespace roseau::camera
