// Brush: lays a covered area over a picture, in a colour that may differ from pixel to pixel.
#pragma once

#include <cstdint>

#include "synthesis/render/coverage.h"
#include "synthesis/render/picture.h"

namespace roseau::render {

namespace detail {

inline constexpr int kFull = 1 << 15;      // covered wholly
inline constexpr float kToNearest = 0.5F;  // before what is positive is cut off

// The mix of what was there and the new colour; exact at both ends.
inline std::uint16_t lay_over(std::uint16_t under, int over, int share) {
  return static_cast<std::uint16_t>(under + (((over - under) * share + kFull / 2) >> 15));
}

template <int kChannels, class InkAt>
void brush(Coverage& coverage, Picture& picture, const InkAt& ink_at) {
  coverage.sweep([&](int y, int left, std::span<const float> shares) {
    std::uint16_t* pixel = picture.row(y) + static_cast<std::size_t>(left) * kChannels;
    for (std::size_t i = 0; i < shares.size(); ++i, pixel += kChannels) {
      const int share = static_cast<int>(shares[i] * kFull + kToNearest);
      if (share == 0) continue;
      const auto& ink = ink_at(left + static_cast<int>(i), y);
      for (int c = 0; c < kChannels; ++c)
        pixel[c] = lay_over(pixel[c], static_cast<int>(ink[static_cast<std::size_t>(c)]), share);
    }
  });
}

}  // namespace detail

/// `ink_at(x, y)` gives the Ink of a pixel, 0..kMostSteps.
template <class InkAt>
void brush(Coverage& coverage, Picture& picture, const InkAt& ink_at) {
  if (picture.channels == 1) {
    detail::brush<1>(coverage, picture, ink_at);
  } else {
    detail::brush<3>(coverage, picture, ink_at);
  }
}

/// One colour all over.
inline void brush_flat(Coverage& coverage, Picture& picture, const Ink& ink) {
  const std::array<int, 3> whole{to_steps(ink[0]), to_steps(ink[1]), to_steps(ink[2])};
  brush(coverage, picture, [&whole](int, int) -> const std::array<int, 3>& { return whole; });
}

}  // namespace roseau::render
