#include "synthesis/camera/canvas.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace roseau::synthesis {

namespace {
constexpr int kOversampling = 2;  // with OpenCV's antialiasing on top
constexpr int kFractionBits = 4;

cv::Scalar to_scalar(const Colour& colour) {
  const auto byte = [](double value) { return std::clamp(value, 0.0, 1.0) * 255; };
  return {byte(colour.blue), byte(colour.green), byte(colour.red), 255};
}
}  // namespace

Canvas::Canvas(const PlaneWindow& window, double plane_y_m, double px_per_m)
    : window_(window), plane_y_m_(plane_y_m), px_per_m_(px_per_m) {
  const auto size_px = [px_per_m](double length_m) { return kOversampling * static_cast<int>(std::ceil(length_m * px_per_m)); };
  pixels_ = cv::Mat(size_px(window.top_m - window.bottom_m), size_px(window.right_m - window.left_m), CV_8UC4,
                    cv::Scalar(0, 0, 0, 0));
}

cv::Point Canvas::fixed_point(const Vec2& point_m) const {
  const double scale = px_per_m_ * kOversampling;
  const double one = 1 << kFractionBits;
  return {static_cast<int>(std::lround(((point_m.x - window_.left_m) * scale - 0.5) * one)),
          static_cast<int>(std::lround(((window_.top_m - point_m.y) * scale - 0.5) * one))};
}

// Antialiased drawing on a clear ground leaves exactly the premultiplied colour: each edge pixel mixes colour and opacity
// with what was there in the same proportion.
void Canvas::polygon(std::span<const Vec2> corners_m, const Colour& colour) {
  std::vector<cv::Point> corners;
  for (const Vec2& corner : corners_m) corners.push_back(fixed_point(corner));
  cv::fillPoly(pixels_, std::vector{corners}, to_scalar(colour), cv::LINE_AA, kFractionBits);
}

void Canvas::disc(Vec2 centre_m, double radius_m, const Colour& colour) {
  const auto radius =
      static_cast<int>(std::lround(radius_m * px_per_m_ * kOversampling * static_cast<double>(1 << kFractionBits)));
  cv::circle(pixels_, fixed_point(centre_m), radius, to_scalar(colour), cv::FILLED, cv::LINE_AA, kFractionBits);
}

void Canvas::stroke(Vec2 from_m, Vec2 to_m, double from_width_m, double to_width_m, const Colour& colour) {
  const double length = std::hypot(to_m.x - from_m.x, to_m.y - from_m.y);
  if (length == 0) return;
  const Vec2 normal{-(to_m.y - from_m.y) / length, (to_m.x - from_m.x) / length};
  const auto side = [&normal](const Vec2& point, double offset) {
    return Vec2{point.x + normal.x * offset, point.y + normal.y * offset};
  };
  const Vec2 corners[] = {side(from_m, from_width_m / 2), side(to_m, to_width_m / 2), side(to_m, -to_width_m / 2),
                          side(from_m, -from_width_m / 2)};
  polygon(corners, colour);
  disc(to_m, to_width_m / 2, colour);
}

Layer Canvas::finish(double blur_px) const {
  Layer layer{.px_per_m = px_per_m_, .plane_y_m = plane_y_m_, .window = window_};
  cv::resize(pixels_, layer.pixels, pixels_.size() / kOversampling, 0, 0, cv::INTER_AREA);
  if (blur_px > 0) cv::GaussianBlur(layer.pixels, layer.pixels, {}, blur_px, blur_px, cv::BORDER_CONSTANT);
  return layer;
}

}  // namespace roseau::synthesis
