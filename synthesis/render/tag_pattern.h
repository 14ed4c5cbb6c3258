// The cells of an AprilTag of family 36h11.
#pragma once

#include <array>

#include "core/result.h"

namespace roseau::render {

/// The printed picture: a white border of one cell, a black one inside it, 6 x 6 cells of code. Rows from the top.
struct TagPattern {
  static constexpr std::size_t kCells = 10;
  std::array<std::array<bool, kCells>, kCells> white{};
};

/// Tag `id` of the family (0..586).
Result<TagPattern> tag36h11(int id);

}  // namespace roseau::render
