#include "core/image_coding/pixel_view.h"

#include <string>

namespace roseau::image {

Result<void> check(const PixelView& view) {
  if (view.width == 0 || view.height == 0) return Error{ErrorCode::invalid_argument, "the picture is empty"};
  const std::size_t needed = std::size_t{view.stride} * (view.height - 1) + view.row_bytes();
  if (view.stride >= view.row_bytes() && view.pixels.size() >= needed && needed <= kMostPixelBytes) return {};
  return Error{ErrorCode::invalid_argument, std::to_string(view.pixels.size()) + " bytes for a picture of " +
                                                std::to_string(view.width) + "x" + std::to_string(view.height) + " with " +
                                                std::to_string(view.stride) + " bytes per row"};
}

}  // namespace roseau::image
