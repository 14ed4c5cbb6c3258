// Part of the plug-in: the one place that knows OpenCV's videoio.
#pragma once

#include <opencv2/videoio.hpp>

#include "drivers/camera/file/video_file.h"

namespace roseau::camera {

class OpencvVideoFile : public VideoFile {
 public:
  explicit OpencvVideoFile(VideoFileOptions options) : options_(std::move(options)) {}

  const std::string& name() const override { return options_.name; }
  bool is_live() const override { return options_.is_paced; }
  Result<void> open(StreamTable& streams) override;
  Result<ReadStatus> read(SampleSink& sink, std::chrono::milliseconds timeout) override;
  void close() override;
  VideoFileInfo info() const override { return info_; }

 private:
  Result<void> check_options() const;
  Result<void> open_file();
  Result<bool> grab();
  std::optional<Duration> time_in_file();
  Result<bool> wait_for_time(std::chrono::milliseconds timeout) const;
  Result<void> retrieve_into(std::span<std::byte> pixels);
  void report_end();
  HostTime time_of_grabbed() const { return start_ + options_.start_offset + grabbed_time_; }
  std::string quoted_path() const { return "video '" + options_.path + "'"; }

  VideoFileOptions options_;
  cv::VideoCapture capture_;
  std::optional<FramePool> pool_;
  cv::Mat colour_;  // decoded picture on its way to mono8
  StreamId stream_ = 0;
  HostTime start_;
  VideoFileInfo info_;
  // The frame taken from the file but not yet handed on.
  bool has_grabbed_ = false;
  bool has_ended_ = false;
  std::uint64_t grabbed_index_ = 0;
  Duration grabbed_time_{0};
  bool trusts_container_ = true;
};

}  // namespace roseau::camera
