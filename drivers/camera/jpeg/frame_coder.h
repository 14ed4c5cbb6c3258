// FrameCoder: frames into the form in which they are stored where that is JPEG, and back at once.
//
// JPEG loses something. What is computed from a recording must be what was computed live, so the live analysis has to see the
// pictures that the recording will give: coding belongs in front of everything, at the camera's edge, and the frame goes on
// with both its stored form and the pixels that this decodes to.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "core/frame.h"
#include "core/image_coding/image_decoder.h"
#include "core/image_coding/jpeg.h"
#include "core/image_coding/png_encoder.h"
#include "core/result.h"

namespace roseau::camera {

/// Buffers of the coded frames of one camera, shared by its coders. Thread-safe. Made with the first frame, and again when
/// frames become larger.
class CodedBuffers {
 public:
  struct Pair {
    FrameLease pixels;
    FrameLease coded;
    explicit operator bool() const { return pixels && coded; }
  };
  /// Empty leases while consumers hold all there are; once some come back, the next one is filled.
  Pair acquire(std::size_t pixel_bytes, std::size_t coded_bytes);

 private:
  std::mutex mutex_;
  std::unique_ptr<FramePool> pixels_;
  std::unique_ptr<FramePool> coded_;
};

/// One per thread.
class FrameCoder {
 public:
  /// `quality` of the JPEG, 1 to 100.
  explicit FrameCoder(int quality) : jpeg_(quality) {}

  /// Codes the frame and replaces its pixels, in `buffers` that suit it (buffers_for). A frame that JPEG cannot hold (16 bits)
  /// or would not make smaller is stored as PNG, and keeps its pixels. Error: it is no picture.
  Result<void> code(Frame& frame, CodedBuffers::Pair buffers);
  static CodedBuffers::Pair buffers_for(const Frame& frame, CodedBuffers& buffers);

 private:
  image::JpegEncoder jpeg_;
  image::PngEncoder png_;
  image::ImageDecoder decoder_;
  std::vector<std::byte> scratch_;  // a JPEG of unknown size
};

}  // namespace roseau::camera
