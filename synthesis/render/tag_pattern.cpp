#include "synthesis/render/tag_pattern.h"

extern "C" {
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
}

#include <fmt/format.h>

#include <cstdlib>
#include <memory>

#include "core/check.h"

namespace roseau::render {

Result<TagPattern> tag36h11(int id) {
  const std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> family(tag36h11_create(), tag36h11_destroy);
  const auto count = static_cast<int>(family->ncodes);
  if (id < 0 || id >= count) {
    return Error{ErrorCode::invalid_argument,
                 fmt::format("tag {} does not exist: family 36h11 has tags 0 to {}", id, count - 1)};
  }
  // The library's own way to free an image is not exported.
  const std::unique_ptr<image_u8_t, void (*)(image_u8_t*)> image(apriltag_to_image(family.get(), id), [](image_u8_t* picture) {
    std::free(picture->buf);
    std::free(picture);
  });
  constexpr auto kCells = static_cast<int>(TagPattern::kCells);
  ROSEAU_CHECK(image->width == kCells && image->height == kCells);
  TagPattern pattern;
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      pattern.white.at(static_cast<std::size_t>(y)).at(static_cast<std::size_t>(x)) =
          image->buf[y * static_cast<int>(image->stride) + x] > 127;
    }
  }
  return pattern;
}

}  // namespace roseau::render
