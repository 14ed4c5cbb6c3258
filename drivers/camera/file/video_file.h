// A video file as a camera.
//
// The decoder (OpenCV's videoio on FFmpeg) pulls in some 250 shared libraries, so it lives in a plug-in,
// lib/roseau/video_file.so beside the program, which is loaded when the first video is opened. Everything else only sees this
// header.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/frame.h"
#include "core/result.h"
#include "core/source.h"
#include "core/time.h"

namespace roseau::camera {

struct VideoFileOptions {
  std::string name = "camera0";  // device
  std::string topic;             // empty: "/<name>/image"
  std::string path;
  PixelFormat format = PixelFormat::bgr8;  // or mono8
  /// Frames per second. Not given: the container's own times, or failing those its frame rate.
  std::optional<double> rate_hz;
  /// When the video's time 0 was. Not given: the moment of opening.
  std::optional<HostTime> start;
  /// Added to every frame's time: this camera was started so much later than `start`.
  Duration start_offset{0};
  /// True: each frame comes when its time has come, as from a live camera (give no `start` then). False: as fast as the
  /// consumer takes them.
  bool is_paced = false;
  /// Frames that consumers may hold at once, at most 64. 0: about 64 MB of them, at least 4.
  std::size_t buffer_count = 0;
};

/// What the file says and what it held so far.
struct VideoFileInfo {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  double rate_hz = 0;                  // as given, else as the file says; 0 = it does not say
  std::uint64_t announced_frames = 0;  // by the file's header; 0 = it does not say
  std::uint64_t frames = 0;            // delivered so far
  std::uint64_t dropped_frames = 0;    // paced only: every buffer was held by a consumer when the frame's time came
  std::string warning;                 // once read to the end: what was wrong with the file; empty: nothing
};

/// Frames with sequence = index in the file, sample_time = start + start_offset + the frame's time in the file. Not paced,
/// arrival_time is the same; paced, it is when the frame was really handed on. Thread rule of SampleSource.
class VideoFile : public SampleSource {
 public:
  /// After a successful open.
  virtual VideoFileInfo info() const = 0;
};

/// Loads the plug-in if need be. Error: it is not there, or belongs to another version of the program. The file itself is
/// not touched before open().
Result<std::unique_ptr<VideoFile>> make_video_file(const VideoFileOptions& options);

}  // namespace roseau::camera
