#include "synthesis/render/coverage.h"

#include <array>
#include <cmath>

#include "core/check.h"

namespace roseau::render {

namespace {

constexpr float kUpright = 1e-3F;  // px

// Integral of clamp(t, 0, 1) from minus infinity.
float ramp_integral(float t) {
  if (t <= 0) return 0;
  return t < 1 ? 0.5F * t * t : t - 0.5F;
}

// The part of a polygon on one side of a line (Sutherland and Hodgman): keeps points with inside(p) >= 0.
template <class Inside>
void cut(std::span<const ImagePoint> polygon, std::vector<ImagePoint>& kept, const Inside& inside) {
  kept.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const ImagePoint& from = polygon[i];
    const ImagePoint& to = polygon[i + 1 < polygon.size() ? i + 1 : 0];
    const float from_inside = inside(from);
    const float to_inside = inside(to);
    if (from_inside >= 0) kept.push_back(from);
    if ((from_inside >= 0) != (to_inside >= 0)) {
      const float share = from_inside / (from_inside - to_inside);
      kept.push_back({from.x + share * (to.x - from.x), from.y + share * (to.y - from.y)});
    }
  }
}

}  // namespace

struct Coverage::Extent {
  float left = 1e30F;
  float top = 1e30F;
  float right = -1e30F;
  float bottom = -1e30F;

  explicit Extent(std::span<const ImagePoint> points) {
    for (const ImagePoint& point : points) {
      left = std::min(left, point.x);
      right = std::max(right, point.x);
      top = std::min(top, point.y);
      bottom = std::max(bottom, point.y);
    }
  }
};

Coverage::Coverage(int width, int height)
    : steps_((static_cast<std::size_t>(width) + 2) * static_cast<std::size_t>(height)),
      stride_(static_cast<std::size_t>(width) + 2) {
  reach_.resize(static_cast<std::size_t>(height));
  for (auto& scratch : scratch_) scratch.reserve(2 * kMaxCorners);
}

bool Coverage::begin(std::span<const ImagePoint> outline, const PixelArea& clip) {
  const Extent extent(outline);
  // Also false for what is not a number.
  if (clip.empty() || !(extent.right > static_cast<float>(clip.left) - 0.5F) ||
      !(extent.left < static_cast<float>(clip.right) - 0.5F) || !(extent.bottom > static_cast<float>(clip.top) - 0.5F) ||
      !(extent.top < static_cast<float>(clip.bottom) - 0.5F)) {
    return false;
  }
  const auto first = [](float low, int limit) {
    return std::max(static_cast<int>(std::floor(std::max(low, -1e6F) + 0.5F)), limit);
  };
  const auto last = [](float high, int limit) {
    return std::min(static_cast<int>(std::ceil(std::min(high, 1e6F) + 0.5F)), limit);
  };
  bounds_ = {first(extent.left, clip.left), first(extent.top, clip.top), last(extent.right, clip.right),
             last(extent.bottom, clip.bottom)};
  std::fill_n(reach_.begin(), bounds_.bottom - bounds_.top, Reach{.first = bounds_.right - bounds_.left, .last = -1});
  add(outline, extent);
  return true;
}

void Coverage::add(std::span<const ImagePoint> outline) { add(outline, Extent(outline)); }

void Coverage::add(std::span<const ImagePoint> outline, const Extent& extent) {
  ROSEAU_CHECK(outline.size() <= kMaxCorners);
  const float left = static_cast<float>(bounds_.left) - 0.5F;
  const float top = static_cast<float>(bounds_.top) - 0.5F;
  const float right = static_cast<float>(bounds_.right) - 0.5F;
  const float bottom = static_cast<float>(bounds_.bottom) - 0.5F;
  if (extent.left >= left && extent.right <= right && extent.top >= top && extent.bottom <= bottom) {
    add_clipped(outline);
    return;
  }
  cut(outline, scratch_[0], [left](const ImagePoint& p) { return p.x - left; });
  cut(scratch_[0], scratch_[1], [right](const ImagePoint& p) { return right - p.x; });
  cut(scratch_[1], scratch_[0], [top](const ImagePoint& p) { return p.y - top; });
  cut(scratch_[0], scratch_[1], [bottom](const ImagePoint& p) { return bottom - p.y; });
  add_clipped(scratch_[1]);
}

void Coverage::add_clipped(std::span<const ImagePoint> outline) {
  // From here on, pixels reach from whole number to whole number, counted from the bounds' corner.
  const float dx = 0.5F - static_cast<float>(bounds_.left);
  const float dy = 0.5F - static_cast<float>(bounds_.top);
  const auto max_x = static_cast<float>(bounds_.right - bounds_.left);
  const auto max_y = static_cast<float>(bounds_.bottom - bounds_.top);
  const auto inside = [=](const ImagePoint& p) {
    return ImagePoint{std::clamp(p.x + dx, 0.0F, max_x), std::clamp(p.y + dy, 0.0F, max_y)};
  };
  if (outline.empty()) return;
  ImagePoint from = inside(outline.back());
  for (const ImagePoint& corner : outline) {
    const ImagePoint to = inside(corner);
    add_edge(from, to);
    from = to;
  }
}

// A piece of an edge within one row covers, of pixel i, the mean over the piece of clamp(i + 1 - x, 0, 1), times its height.
inline void Coverage::add_piece(int row, float x_begin, float x_end, float height) {
  const float low = std::min(x_begin, x_end);
  const float high = std::max(x_begin, x_end);
  const int first = static_cast<int>(low);
  const int last = static_cast<int>(high);
  float* steps = steps_.data() + static_cast<std::size_t>(row) * stride_;
  Reach& reach = reach_[static_cast<std::size_t>(row)];
  reach.first = std::min(reach.first, first);
  reach.last = std::max(reach.last, last + 1);
  // Most pieces lie within one pixel. Upright ones, too, where the general formula would divide rounding errors by next to
  // nothing.
  if (first == last || high - low < kUpright) {
    const float middle = 0.5F * (low + high);
    const int pixel = static_cast<int>(middle);
    const float share = height * (static_cast<float>(pixel + 1) - middle);
    steps[pixel] += share;
    steps[pixel + 1] += height - share;
    return;
  }
  add_long_piece(steps, low, high, height);
}

// What lies to the right of an edge is covered; an edge that goes up takes away what one that goes down has added.
void Coverage::add_edge(ImagePoint from, ImagePoint to) {
  if (from.y == to.y) return;
  const float direction = from.y < to.y ? 1.0F : -1.0F;
  if (from.y > to.y) std::swap(from, to);
  const float slope = (to.x - from.x) / (to.y - from.y);
  const int last = std::min(static_cast<int>(to.y), bounds_.bottom - bounds_.top - 1);
  float x = from.x;
  float y = from.y;
  for (int row = static_cast<int>(from.y); row <= last; ++row) {
    const float next_y = std::min(static_cast<float>(row + 1), to.y);
    const float next_x = next_y == to.y ? to.x : from.x + (next_y - from.y) * slope;
    add_piece(row, x, next_x, direction * (next_y - y));
    x = next_x;
    y = next_y;
  }
}

void Coverage::add_long_piece(float* steps, float low, float high, float height) {
  const int first = static_cast<int>(low);
  const int last = static_cast<int>(high);
  const float density = height / (high - low);
  float before = 0;
  for (int i = first; i <= last; ++i) {
    const float c = static_cast<float>(i + 1);
    const float covered = density * (ramp_integral(c - low) - ramp_integral(c - high));
    steps[i] += covered - before;
    before = covered;
  }
  steps[last + 1] += height - before;
}

}  // namespace roseau::render
