// Coverage: which share of each pixel polygons cover, exactly (up to float rounding). The base of all drawing.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace roseau::render {

/// Image coordinates: the centre of the upper left pixel is (0, 0).
struct ImagePoint {
  float x = 0;
  float y = 0;
};

/// Pixels [left, right) x [top, bottom).
struct PixelArea {
  int left = 0;
  int top = 0;
  int right = 0;
  int bottom = 0;

  bool empty() const { return left >= right || top >= bottom; }
};

class Coverage {
 public:
  /// For pictures of up to this size.
  Coverage(int width, int height);

  /// Starts with a polygon (up to kMaxCorners corners, not crossing itself), cut off at `clip`, which lies within the picture.
  /// False if nothing of it is in there.
  bool begin(std::span<const ImagePoint> outline, const PixelArea& clip);

  /// Another polygon inside the first one's bounds: one of opposite orientation cuts a hole, polygons that touch join without
  /// a seam.
  void add(std::span<const ImagePoint> outline);

  /// Calls paint(y, x, shares) for each row of what begin() and add() covered: shares of the pixels from x on, 0..1.
  /// The outermost pixels of a row may be 0.
  template <class Paint>
  void sweep(const Paint& paint);

  static constexpr std::size_t kMaxCorners = 64;

 private:
  struct Extent;
  void add(std::span<const ImagePoint> outline, const Extent& extent);
  void add_clipped(std::span<const ImagePoint> outline);
  void add_edge(ImagePoint from, ImagePoint to);
  void add_piece(int row, float x_begin, float x_end, float height);
  static void add_long_piece(float* steps, float low, float high, float height);

  // Changes of the covered share from one pixel to the next, `stride_` floats a row; bounds_ says which part is in use.
  // Zero but between begin() and sweep().
  std::vector<float> steps_;
  std::size_t stride_ = 0;
  // Per row of the bounds, the first and last column where the share changes: next to a slanting twig most columns are empty.
  struct Reach {
    int first = 0;
    int last = 0;
  };
  std::vector<Reach> reach_;
  PixelArea bounds_;
  std::vector<ImagePoint> scratch_[2];
};

template <class Paint>
void Coverage::sweep(const Paint& paint) {
  const int width = bounds_.right - bounds_.left;
  for (int y = bounds_.top; y < bounds_.bottom; ++y) {
    const auto [first, last] = reach_[static_cast<std::size_t>(y - bounds_.top)];
    if (first > last) continue;
    float* row = steps_.data() + static_cast<std::size_t>(y - bounds_.top) * stride_;
    const int end = std::min(last + 1, width);
    float share = 0;
    for (int x = first; x < end; ++x) {
      share += row[x];
      row[x] = std::min(share < 0 ? -share : share, 1.0F);
    }
    paint(y, bounds_.left + first, std::span<const float>(row + first, row + end));
    std::fill(row + first, row + last + 1, 0.0F);
  }
}

}  // namespace roseau::render
