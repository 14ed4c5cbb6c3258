// The drawing half of ScenePainter.
#include <algorithm>
#include <cmath>

#include "synthesis/render/brush.h"
#include "synthesis/render/scene_painter.h"

namespace roseau::render {

namespace {

constexpr Colour kPlate{0.045, 0.045, 0.05};
constexpr Colour kLens{0.11, 0.11, 0.10};  // an LED that is off
constexpr Colour kLitLed{1.0, 0.93, 0.75};
constexpr Colour kPaper{0.86, 0.86, 0.84};
constexpr Colour kPrint{0.045, 0.045, 0.05};

float cross(const ImagePoint& a, const ImagePoint& b) { return a.x * b.y - a.y * b.x; }
ImagePoint minus(const ImagePoint& a, const ImagePoint& b) { return {a.x - b.x, a.y - b.y}; }
ImagePoint halfway(const ImagePoint& a, const ImagePoint& b) { return {0.5F * (a.x + b.x), 0.5F * (a.y + b.y)}; }

Ink shaded(const Ink& ink, float light) { return {ink[0] * light, ink[1] * light, ink[2] * light}; }

// What may come out of shading is cut off at what a picture holds.
std::array<int, 3> whole(const Ink& ink) { return {to_steps(ink[0]), to_steps(ink[1]), to_steps(ink[2])}; }

constexpr float kCapWidth_px = 0.75F;  // thinner wood ends straight

}  // namespace

void ScenePainter::draw(Coverage& coverage, Picture& picture, const PixelArea& clip) {
  for (const std::uint32_t index : order_) {
    const Element& element = elements_[index];
    if (!element.seen) continue;
    switch (element.shape) {
      case Shape::leaf:
        draw_leaf(element, coverage, picture, clip);
        break;
      case Shape::wood:
      case Shape::pole:
        draw_round(element, rounds_[element.index], coverage, picture, clip);
        break;
      case Shape::ball:
        draw_ball(element, coverage, picture, clip);
        break;
      case Shape::board:
        draw_board(element, coverage, picture, clip);
        break;
      case Shape::tag:
        draw_tag(element, coverage, picture, clip);
        break;
    }
  }
}

// Two tones, one on each side of the mid-rib, that run into each other within half a pixel.
void ScenePainter::draw_leaf(const Element& element, Coverage& coverage, Picture& picture, const PixelArea& clip) const {
  const std::span<const ImagePoint> outline(image_.data() + element.first_vertex, element.vertex_count);
  if (!coverage.begin(outline, clip)) return;
  const LeafLight& light = leaf_lights_[element.index];
  const ImagePoint rib = minus(outline[3], outline[0]);
  const float rib_length = std::sqrt(rib.x * rib.x + rib.y * rib.y);
  const float side = cross(rib, minus(outline[1], outline[0])) < 0 ? -1.0F : 1.0F;
  const float scale = rib_length > 1e-3F ? side / rib_length : 0.0F;
  const std::array<int, 3> left = whole(light.left);
  const std::array<int, 3> right = whole(light.right);
  brush(coverage, picture, [&](int x, int y) {
    const ImagePoint at{static_cast<float>(x) - outline[0].x, static_cast<float>(y) - outline[0].y};
    const int share = static_cast<int>(256 * std::clamp(0.5F + scale * cross(rib, at), 0.0F, 1.0F));
    std::array<int, 3> ink;
    for (std::size_t c = 0; c < 3; ++c) ink[c] = right[c] + (((left[c] - right[c]) * share) >> 8);
    return ink;
  });
}

void ScenePainter::draw_round(const Element& element, const Round& round, Coverage& coverage, Picture& picture,
                              const PixelArea& clip) const {
  const ImagePoint* corner = image_.data() + element.first_vertex;
  const ImagePoint from = halfway(corner[0], corner[3]);
  const ImagePoint to = halfway(corner[1], corner[2]);
  const ImagePoint from_side = minus(corner[0], from);
  const ImagePoint to_side = minus(corner[1], to);
  const ImagePoint axis = minus(to, from);
  const float axis_length = std::max(std::hypot(axis.x, axis.y), 1e-3F);
  const ImagePoint along{axis.x / axis_length, axis.y / axis_length};
  const float from_width = std::hypot(from_side.x, from_side.y);
  const float to_width = std::hypot(to_side.x, to_side.y);

  std::array<ImagePoint, 10> outline{corner[0], corner[1], corner[2], corner[3]};
  std::size_t corners = 4;
  if (element.shape == Shape::wood && from_width > kCapWidth_px) {
    // Round ends close the joints between pieces that bend against each other.
    constexpr float kHalf = 0.70710678F;
    const auto around = [&](const ImagePoint& centre, const ImagePoint& side, float width, float cosine, float sine) {
      return ImagePoint{centre.x + cosine * side.x + sine * width * along.x,
                        centre.y + cosine * side.y + sine * width * along.y};
    };
    outline = {corner[0],
               corner[1],
               around(to, to_side, to_width, kHalf, kHalf),
               around(to, to_side, to_width, 0, 1),
               around(to, to_side, to_width, -kHalf, kHalf),
               corner[2],
               corner[3],
               around(from, from_side, from_width, -kHalf, -kHalf),
               around(from, from_side, from_width, 0, -1),
               around(from, from_side, from_width, kHalf, -kHalf)};
    corners = outline.size();
  }
  if (!coverage.begin(std::span(outline).first(corners), clip)) return;

  const float width = 0.5F * (from_width + to_width);
  if (width < 1) {
    // Too thin to show its roundness: the mean over its width.
    const float lit = std::max(0.0F, 0.785F * round.sun_facing) + 0.25F * std::abs(round.sun_across);
    brush_flat(coverage, picture, shaded(round.ink, ambient_ + sun_ * round.sunlight * lit));
    return;
  }
  const ImagePoint normal = from_width > 0 ? ImagePoint{from_side.x / from_width, from_side.y / from_width} : ImagePoint{};
  const float relief = round.bark ? std::clamp((width - 1) / 3, 0.0F, 1.0F) : 0.0F;
  const float metres_per_px = round.length_m / axis_length;
  brush(coverage, picture, [&](int x, int y) {
    const ImagePoint at{static_cast<float>(x) - from.x, static_cast<float>(y) - from.y};
    const float s = std::clamp((at.x * along.x + at.y * along.y) / axis_length, 0.0F, 1.0F);
    const float half_width = from_width + s * (to_width - from_width);
    const float across = std::clamp((at.x * normal.x + at.y * normal.y) / half_width, -1.0F, 1.0F);
    const float facing = std::sqrt(1 - across * across);
    const float lit = std::max(0.0F, across * round.sun_across + facing * round.sun_facing);
    float light = ambient_ * (0.55F + 0.45F * facing) + sun_ * round.sunlight * lit;
    if (relief > 0) {
      const float v = (round.along_m + s * axis_length * metres_per_px) * kBarkPerMetre;
      const int row = static_cast<int>(std::floor(v)) & (kBarkAlong - 1);
      const int column = static_cast<int>((across * 0.5F + 0.5F) * (kBarkAround - 1));
      light *= 1 + relief * (bark_[static_cast<std::size_t>(row) * kBarkAround + static_cast<std::size_t>(column)] - 1);
    }
    return whole(shaded(round.ink, light));
  });
}

void ScenePainter::draw_ball(const Element& element, Coverage& coverage, Picture& picture, const PixelArea& clip) const {
  const std::span<const ImagePoint> outline(image_.data() + element.first_vertex, element.vertex_count);
  if (!coverage.begin(outline, clip)) return;
  const std::size_t quarter = outline.size() / 4;
  const ImagePoint centre = halfway(outline[0], outline[2 * quarter]);
  // The silhouette is an ellipse, next to a circle: its two half axes to the right and down take a pixel back to the ball.
  const ImagePoint right = minus(outline[0], centre);
  const ImagePoint down = minus(outline[quarter], centre);
  const float area = cross(right, down);
  const auto sun_x = static_cast<float>(sun_in_camera_.x);
  const auto sun_y = static_cast<float>(sun_in_camera_.y);
  const auto sun_z = static_cast<float>(sun_in_camera_.z);
  const Ink& ink = ball_inks_[element.index];
  brush(coverage, picture, [&](int x, int y) {
    const ImagePoint at{static_cast<float>(x) - centre.x, static_cast<float>(y) - centre.y};
    float across = cross(at, down) / area;
    float below = cross(right, at) / area;
    const float out = across * across + below * below;
    if (out > 1) {
      across /= std::sqrt(out);
      below /= std::sqrt(out);
    }
    const float facing = std::sqrt(std::max(0.0F, 1 - out));
    const float lit = std::max(0.0F, across * sun_x + below * sun_y - facing * sun_z);
    return whole(shaded(ink, ambient_ * (sun_ > 0 ? 0.75F + 0.25F * facing : 1.0F) + sun_ * lit));
  });
}

void ScenePainter::draw_board(const Element& element, Coverage& coverage, Picture& picture, const PixelArea& clip) const {
  const ImagePoint* corner = image_.data() + element.first_vertex;
  if (!coverage.begin({corner, 4}, clip)) return;
  brush_flat(coverage, picture, ink_(kPlate));
  const ImagePoint* lens = corner + 4;
  for (std::size_t row = 0; row < kLedRows; ++row) {
    for (std::size_t column = 0; column < kLedColumns; ++column, lens += kLedCorners) {
      draw_led({lens, kLedCorners}, row, column, coverage, picture, clip);
    }
  }
}

// An LED's own light does not change with the daylight that the whole picture is scaled by.
void ScenePainter::draw_led(std::span<const ImagePoint> outline, std::size_t row, std::size_t column, Coverage& coverage,
                            Picture& picture, const PixelArea& clip) const {
  const LedBoard& board = *scene_.description().led_board;
  const LedSchedule schedule = led_schedule(board, row, column);
  if (!schedule.populated || !coverage.begin(outline, clip)) return;
  const double brightness = (schedule.fine_ring ? board.fine_ring_brightness : board.brightness) / double{light_level_};
  const Ink off = ink_(kLens);
  const Ink lit = ink_(scaled(kLitLed, brightness));
  int ink_row = -1;  // the pixel row that `ink` is for: with a rolling shutter each has its own time
  std::array<int, 3> ink{};
  brush(coverage, picture, [&](int, int y) -> const std::array<int, 3>& {
    if (y != ink_row) {
      const double start = exposure_.start_ticks + y * exposure_.ticks_per_row;
      const auto share = static_cast<float>(schedule.lit_share(start, start + exposure_.duration_ticks));
      ink = whole({off[0] + share * lit[0], off[1] + share * lit[1], off[2] + share * lit[2]});
      ink_row = y;
    }
    return ink;
  });
}

// White paper, on it the black cells as one shape: neighbours join without a seam.
void ScenePainter::draw_tag(const Element& element, Coverage& coverage, Picture& picture, const PixelArea& clip) const {
  constexpr std::size_t kCells = TagPattern::kCells;
  const ImagePoint* corner = image_.data() + element.first_vertex;
  const auto at = [corner](std::size_t row, std::size_t column) { return corner[row * (kCells + 1) + column]; };
  const auto rectangle = [&at](std::size_t top, std::size_t left, std::size_t bottom, std::size_t right) {
    return std::array{at(top, left), at(top, right), at(bottom, right), at(bottom, left)};
  };
  // The edge of the square `margin` cells in, with all its points: a distorting lens bends it.
  std::array<ImagePoint, 4 * kCells> edge;
  const auto square = [&](std::size_t margin) {
    const std::size_t side = kCells - 2 * margin;
    const std::size_t end = kCells - margin;
    for (std::size_t i = 0; i < side; ++i) {
      edge[i] = at(margin, margin + i);
      edge[side + i] = at(margin + i, end);
      edge[2 * side + i] = at(end, end - i);
      edge[3 * side + i] = at(end - i, margin);
    }
    return std::span<const ImagePoint>(edge).first(4 * side);
  };
  const std::size_t index = element.index;
  const float light = tag_lights_[index];
  if (!coverage.begin(square(0), clip)) return;
  brush_flat(coverage, picture, shaded(ink_(kPaper), light));
  const bool from_behind = tag_from_behind_[index];
  if (from_behind && scene_.back_tags().empty()) return;
  if (!coverage.begin(square(1), clip)) return;
  const TagPattern& pattern = from_behind ? scene_.back_tags()[index] : scene_.front_tags()[index];
  for (std::size_t row = 1; row + 1 < kCells; ++row) {
    for (std::size_t column = 1; column + 1 < kCells; ++column) {
      if (!pattern.white[row][column]) continue;
      std::array<ImagePoint, 4> hole = rectangle(row, column, row + 1, column + 1);
      std::ranges::reverse(hole);
      coverage.add(hole);
    }
  }
  brush_flat(coverage, picture, shaded(ink_(kPrint), light));
}

}  // namespace roseau::render
