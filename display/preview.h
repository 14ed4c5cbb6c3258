// Preview: a frame as a small JPEG for the page.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/frame.h"
#include "core/result.h"

namespace roseau::display {

/// One encoder per thread: it keeps its buffers from picture to picture.
class PreviewEncoder {
 public:
  /// Pictures wider than `max_width_px` are scaled down to it, keeping their aspect; `quality`: JPEG, 1 to 100.
  PreviewEncoder(std::uint32_t max_width_px, int quality);
  ~PreviewEncoder();
  PreviewEncoder(const PreviewEncoder&) = delete;
  PreviewEncoder& operator=(const PreviewEncoder&) = delete;

  /// 16-bit pictures show their upper 8 bits. The bytes stay valid until the next call.
  Result<std::string_view> encode(const Frame& frame);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace roseau::display
