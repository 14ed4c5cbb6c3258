#include "schema/image_motion.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <string_view>
#include <utility>

namespace roseau::schema {

namespace {

constexpr Color kGood{0.1, 0.85, 0.3, 1};
constexpr Color kDisagrees{0.95, 0.3, 0.1, 1};
constexpr Color kBackground{0.6, 0.6, 0.6, 0.6};
constexpr double kVectorThickness_px = 1;
constexpr double kTargetThickness_px = 2;
constexpr double kFontSize_px = 16;

std::string name_of_target(std::uint8_t target) {
  return target == ImageMotion::kBackground ? "background" : std::to_string(target);
}

std::string text_of(bool value) { return value ? "true" : "false"; }

std::string text_of(float value) {
  std::array<char, 32> text;
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end};
}

Color color_of(std::uint8_t target, bool good) {
  if (!good) return kDisagrees;
  return target == ImageMotion::kBackground ? kBackground : kGood;
}

PointsAnnotation rectangle(const ImageMotion::Target& target, HostTime sample_time) {
  const ImageRect& region = target.region;
  const double right = region.x + region.width;
  const double bottom = region.y + region.height;
  return {.timestamp = sample_time,
          .type = PointsAnnotation::Type::line_loop,
          .points = {{region.x, region.y}, {right, region.y}, {right, bottom}, {region.x, bottom}},
          .outline_color = target.valid ? kGood : kDisagrees,
          .thickness = kTargetThickness_px,
          .metadata = {{"name", target.name}, {"health", text_of(target.health)}, {"valid", text_of(target.valid)}}};
}

const std::string* find_value(const std::vector<KeyValuePair>& metadata, std::string_view key) {
  const auto found = std::ranges::find(metadata, key, &KeyValuePair::key);
  return found == metadata.end() ? nullptr : &found->value;
}

template <class T>
bool parse_number(const std::string& text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

Error malformed(const std::string& what) { return {ErrorCode::corrupt, "image annotations: " + what}; }

Result<void> add_vectors(const PointsAnnotation& annotation, ImageMotion& motion) {
  const std::string* target_name = find_value(annotation.metadata, "target");
  const std::string* good = find_value(annotation.metadata, "good");
  std::uint8_t target = ImageMotion::kBackground;
  if (target_name == nullptr || good == nullptr || (*target_name != "background" && !parse_number(*target_name, target))) {
    return malformed("motion vectors without their target");
  }
  if (annotation.points.size() % 2 != 0) return malformed("a motion vector without its end");
  for (std::size_t i = 0; i < annotation.points.size(); i += 2) {
    const Vec2& before = annotation.points[i];
    const Vec2& now = annotation.points[i + 1];
    motion.points.push_back({static_cast<float>(now.x), static_cast<float>(now.y), static_cast<float>(now.x - before.x),
                             static_cast<float>(now.y - before.y), target, *good == "true"});
  }
  return {};
}

Result<void> add_target(const PointsAnnotation& annotation, ImageMotion& motion) {
  const std::string* name = find_value(annotation.metadata, "name");
  const std::string* health = find_value(annotation.metadata, "health");
  const std::string* valid = find_value(annotation.metadata, "valid");
  ImageMotion::Target target;
  if (name == nullptr || health == nullptr || valid == nullptr || annotation.points.size() != 4 ||
      !parse_number(*health, target.health)) {
    return malformed("a rectangle that is no target");
  }
  const Vec2& upper_left = annotation.points[0];
  const Vec2& lower_right = annotation.points[2];
  target.name = *name;
  target.region = {upper_left.x, upper_left.y, lower_right.x - upper_left.x, lower_right.y - upper_left.y};
  target.valid = *valid == "true";
  motion.targets.push_back(std::move(target));
  return {};
}

}  // namespace

ImageAnnotationsMessage annotations_from_motion(const ImageMotion& motion, HostTime sample_time) {
  ImageAnnotationsMessage message;
  for (const auto& target : motion.targets) {
    message.points.push_back(rectangle(target, sample_time));
    message.texts.push_back(
        {sample_time, {target.region.x, target.region.y}, target.name, kFontSize_px, target.valid ? kGood : kDisagrees});
  }
  std::map<std::pair<std::uint8_t, bool>, std::vector<Vec2>> vectors;  // ordered: the same motion gives the same bytes
  for (const auto& point : motion.points) {
    const Vec2 now{point.x, point.y};
    auto& group = vectors[{point.target, point.good}];
    group.push_back({now.x - static_cast<double>(point.dx), now.y - static_cast<double>(point.dy)});
    group.push_back(now);
  }
  for (auto& [key, points] : vectors) {
    const auto [target, good] = key;
    message.points.push_back({.timestamp = sample_time,
                              .type = PointsAnnotation::Type::line_list,
                              .points = std::move(points),
                              .outline_color = color_of(target, good),
                              .thickness = kVectorThickness_px,
                              .metadata = {{"target", name_of_target(target)}, {"good", text_of(good)}}});
  }
  return message;
}

Result<ImageMotion> motion_from_annotations(const ImageAnnotationsMessage& annotations) {
  ImageMotion motion;
  for (const auto& annotation : annotations.points) {
    const bool vectors = annotation.type == PointsAnnotation::Type::line_list;
    auto added = vectors ? add_vectors(annotation, motion) : add_target(annotation, motion);
    if (!added) return added.error();
  }
  return motion;
}

}  // namespace roseau::schema
