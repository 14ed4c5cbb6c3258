// The 8-bit grey picture that tracking works on, from any frame format.
#pragma once

#include <opencv2/core/mat.hpp>

#include "core/frame.h"
#include "core/result.h"

namespace roseau::tracking {

/// Converts frames to 8-bit grey. mono16 frames of cameras with 10, 12 or 14 bits come with the bits at the low end or the
/// high end of the word; the shift is decided by the first frame and kept (part of a checkpoint), or given.
class GrayConverter {
 public:
  /// Bits used in a mono16 word, 9 to 16; 0: the smallest of 10, 12, 14, 16 that holds the first frame's brightest pixel.
  explicit GrayConverter(int mono16_significant_bits = 0) : mono16_bits_(mono16_significant_bits) {}

  /// `gray` is a view of the frame's own pixels where they are 8-bit grey already (keep the lease), else `storage`, which is
  /// reused. An Error names what is wrong with the frame.
  Result<cv::Mat> convert(const Frame& frame, cv::Mat& storage);

  int mono16_bits() const { return mono16_bits_; }
  void set_mono16_bits(int bits) { mono16_bits_ = bits; }

 private:
  int mono16_bits_;
};

}  // namespace roseau::tracking
