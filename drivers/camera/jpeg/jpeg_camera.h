// JpegCamera: a camera, live or not, whose frames are stored as JPEG (frame_coder.h says why that is done here).
#pragma once

#include <memory>
#include <string>

#include "core/source.h"
#include "drivers/camera/jpeg/frame_coder.h"

namespace roseau::camera {

struct JpegOptions {
  int quality = 90;  // 1 to 100
  /// Live cameras. One thread codes and decodes some 150 MB of pixels per second: 1280x1024 at 60 Hz takes half of one.
  std::size_t threads = 2;
  /// Live cameras: frames that wait for a thread or for their turn. When there are more, the newest is dropped, and counted.
  std::size_t most_waiting = 8;
};

/// Around a camera; other sources' samples than frames pass in their order.
///
/// A live camera is read by a thread of its own, so that coding never holds up the device; further threads code, and read()
/// hands on what they have done, in order. Any other source is coded in read(), and waits for its consumers.
class JpegCamera final : public SampleSource {
 public:
  JpegCamera(std::unique_ptr<SampleSource> camera, const JpegOptions& options);
  ~JpegCamera() override;

  const std::string& name() const override { return camera_->name(); }
  bool is_live() const override { return camera_->is_live(); }
  Result<void> open(StreamTable& streams) override;
  Result<ReadStatus> read(SampleSink& sink, std::chrono::milliseconds timeout) override;
  void close() override;

 private:
  class Workshop;

  std::unique_ptr<SampleSource> camera_;
  const JpegOptions options_;
  std::shared_ptr<CodedBuffers> buffers_ = std::make_shared<CodedBuffers>();
  FrameCoder coder_;                    // for a source that is not live
  std::unique_ptr<Workshop> workshop_;  // of a live one, while it is open
};

/// In front of a sink, for sources that are not live: frames become what their JPEG decodes to, everything else passes.
class JpegSink final : public SampleSink {
 public:
  JpegSink(SampleSink& sink, FrameCoder& coder, CodedBuffers& buffers) : sink_(sink), coder_(coder), buffers_(buffers) {}
  /// Waits for a buffer. A frame that is no picture is dropped.
  bool receive(Sample sample) override;
  void flush() override { sink_.flush(); }

 private:
  SampleSink& sink_;
  FrameCoder& coder_;
  CodedBuffers& buffers_;
};

}  // namespace roseau::camera
