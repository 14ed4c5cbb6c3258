#include "synthesis/render/scene_painter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/check.h"
#include "core/random.h"
#include "synthesis/render/value_noise.h"

namespace roseau::render {

namespace {

constexpr Colour kBark{0.52, 0.43, 0.34};
constexpr Colour kTwig{0.40, 0.35, 0.24};
constexpr Colour kLeafShadow{0.07, 0.14, 0.05};
constexpr Colour kLeafMiddle{0.27, 0.44, 0.14};
constexpr Colour kLeafLit{0.64, 0.77, 0.30};
constexpr double kTwigRadius_m = 0.012;  // bark grows over thicker wood

constexpr std::uint64_t kBarkStream = 206;
constexpr std::size_t kBallCorners = 24;

constexpr double kBarPiece_m = 0.1;  // bars are drawn in pieces, so that a branch may pass before one and behind the next

// How far outside a circle the corners of a polygon lie that has the circle's area.
double outside(std::size_t corners) {
  const double angle = 2 * std::numbers::pi / static_cast<double>(corners);
  return std::sqrt(angle / std::sin(angle));
}

std::vector<float> make_bark(std::uint64_t seed, int cells_around, int cells_along) {
  const ValueNoise noise(seed, kBarkStream, cells_along / 8);
  std::vector<float> bark;
  for (int along = 0; along < cells_along; ++along) {
    for (int around = 0; around < cells_around; ++around) {
      // Furrows run along the wood.
      const double furrows = noise.octaves(along * 0.125, around * 0.55, 3, 0.7);
      bark.push_back(static_cast<float>(0.55 + 0.9 * furrows));
    }
  }
  return bark;
}

}  // namespace

ScenePainter::ScenePainter(const VisibleScene& scene, const calib::Projection& projection, const InkMaker& ink)
    : scene_(scene),
      projection_(projection),
      ink_(ink),
      camera_from_world_(projection.camera().rotation_camera_from_world),
      sun_in_camera_(rotated(camera_from_world_, scene.to_sun())),
      ambient_(static_cast<float>(scene.description().lighting.ambient)),
      sun_(static_cast<float>(scene.description().lighting.sun)),
      bark_(make_bark(scene.description().seed, kBarkAround, kBarkAlong)) {
  constexpr std::array<Colour, 4> kTints{{{1, 1, 1}, {1.12, 1.0, 0.9}, {0.90, 0.96, 1.05}, {1.05, 1.06, 0.85}}};
  for (std::size_t tint = 0; tint < kTints.size(); ++tint) {
    for (std::size_t i = 0; i < 256; ++i) {
      const double lit = static_cast<double>(i) / 255;
      const Colour c = lit < 0.45 ? mix(kLeafShadow, kLeafMiddle, lit / 0.45) : mix(kLeafMiddle, kLeafLit, (lit - 0.45) / 0.55);
      greens_.at(tint).at(i) =
          ink_({c.red * kTints.at(tint).red, c.green * kTints.at(tint).green, c.blue * kTints.at(tint).blue});
    }
  }
  for (const MarkerBall& ball : scene.description().balls) ball_inks_.push_back(ink_(ball.colour));
  camera_from_node_.resize(scene.tree().nodes.size());
  node_in_camera_.resize(scene.tree().nodes.size());
}

Vec3 ScenePainter::in_camera(const Vec3& point_in_world) const {
  return rotated(camera_from_world_, subtract(point_in_world, projection_.camera().position_in_world_m));
}

// ---------------------------------------------------------------------------------------------------------------------
// Where everything is

void ScenePainter::pose(const SceneMoment& moment, const BoardExposure& exposure) {
  exposure_ = exposure;
  light_level_ = static_cast<float>(moment.light_level);
  elements_.clear();
  depths_m_.clear();
  vertices_.clear();
  leaf_lights_.clear();
  rounds_.clear();
  tag_from_behind_.clear();
  tag_lights_.clear();
  pose_nodes(moment);
  pose_leaves();
  pose_wood();
  pose_balls();
  pose_poles();
  pose_board();
  if (moment.rig.visible) pose_rig(moment.rig);
  project_vertices();
  sort_elements();
}

void ScenePainter::begin_element(Shape shape, std::size_t index) {
  elements_.push_back({.shape = shape,
                       .index = static_cast<std::uint32_t>(index),
                       .first_vertex = static_cast<std::uint32_t>(vertices_.size())});
}

void ScenePainter::finish_element(double depth_m) {
  Element& element = elements_.back();
  element.vertex_count = static_cast<std::uint32_t>(vertices_.size()) - element.first_vertex;
  element.seen = std::all_of(vertices_.begin() + element.first_vertex, vertices_.end(),
                             [this](const Vec3& vertex) { return projection_.sees(vertex, 0.05); });
  depths_m_.push_back(static_cast<float>(depth_m));
}

void ScenePainter::pose_nodes(const SceneMoment& moment) {
  const auto& nodes = scene_.tree().nodes;
  ROSEAU_CHECK(moment.displacement_m.size() == nodes.size() && moment.rotation_rad.size() == nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    node_in_camera_[i] = in_camera(add(nodes[i].position_m, moment.displacement_m[i]));
    camera_from_node_[i] = product(camera_from_world_, rotation(moment.rotation_rad[i]));
  }
}

void ScenePainter::pose_leaves() {
  const auto& leaves = scene_.leaves();
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const VisibleLeaf& leaf = leaves[i];
    const Matrix3& turn = camera_from_node_[leaf.node];
    const Vec3& node = node_in_camera_[leaf.node];
    begin_element(Shape::leaf, i);
    for (const Vec3& corner : leaf.corners_m) vertices_.push_back(add(node, rotated(turn, corner)));
    const Vec3 middle = times(0.5, add(vertices_[elements_.back().first_vertex], vertices_[elements_.back().first_vertex + 3]));
    finish_element(middle.z);
    leaf_lights_.push_back(light_on(leaf, rotated(turn, leaf.normal), middle));
  }
}

// The side that is seen is lit by the sun directly, or shines through.
ScenePainter::LeafLight ScenePainter::light_on(const VisibleLeaf& leaf, const Vec3& normal, const Vec3& at) const {
  const double facing = -dot(normal, at);
  const double cosine = dot(normal, sun_in_camera_);
  const bool direct = (facing > 0) == (cosine > 0);
  const double sunlit = std::abs(cosine) * (direct ? 0.85 : 0.55) * double{leaf.sunlight};
  const double lit = double{ambient_} * 0.62 * double{leaf.skylight} + double{sun_} * sunlit;
  // The halves of a blade are folded a little against each other.
  const auto tone = [&](double fold) {
    return greens_.at(leaf.tint)[static_cast<std::size_t>(std::clamp(255 * (lit * fold + 0.02), 0.0, 255.0))];
  };
  return {tone(1.10), tone(0.86)};
}

// A tapered piece of round material: the silhouette's four corners, exact for the lens as they are points of the space.
void ScenePainter::add_round(Shape shape, std::size_t index, const Vec3& from, const Vec3& to, double from_radius_m,
                             double to_radius_m, Round round) {
  const Vec3 middle = times(0.5, add(from, to));
  const Vec3 axis = unit(subtract(to, from));
  const Vec3 side = unit(cross(axis, middle));
  const Vec3 facing = unit(cross(side, axis));
  round.sun_across = static_cast<float>(dot(side, sun_in_camera_));
  round.sun_facing = static_cast<float>(dot(facing, sun_in_camera_) * (dot(facing, middle) < 0 ? 1 : -1));
  round.length_m = static_cast<float>(length(subtract(to, from)));
  begin_element(shape, index);
  vertices_.push_back(add(from, times(from_radius_m, side)));
  vertices_.push_back(add(to, times(to_radius_m, side)));
  vertices_.push_back(subtract(to, times(to_radius_m, side)));
  vertices_.push_back(subtract(from, times(from_radius_m, side)));
  finish_element(middle.z);
  rounds_.push_back(round);
}

void ScenePainter::pose_wood() {
  const auto& nodes = scene_.tree().nodes;
  const Ink bark = ink_(kBark);
  const Ink twig = ink_(kTwig);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const structure::TreeNode& node = nodes[i];
    if (node.parent < 0) continue;
    const bool has_bark = node.start_radius_m > kTwigRadius_m;
    add_round(Shape::wood, rounds_.size(), node_in_camera_[static_cast<std::size_t>(node.parent)], node_in_camera_[i],
              node.start_radius_m, node.end_radius_m,
              {.ink = has_bark ? bark : twig,
               .sunlight = scene_.wood_sunlight()[i],
               .along_m = static_cast<float>(nodes[static_cast<std::size_t>(node.parent)].position_m.z),
               .bark = has_bark});
  }
}

void ScenePainter::pose_balls() {
  const auto& balls = scene_.description().balls;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Vec3 centre = add(node_in_camera_[balls[i].node], rotated(camera_from_node_[balls[i].node], balls[i].offset_m));
    const double radius = balls[i].diameter_m / 2;
    // The silhouette is the circle where rays from the camera touch the ball. A little nearer than its centre.
    const double share = radius * radius / std::max(dot(centre, centre), 4 * radius * radius);
    const Vec3 silhouette = times(1 - share, centre);
    const double silhouette_radius = radius * std::sqrt(1 - share);
    const Vec3 right = unit(cross({0, 1, 0}, centre));
    const Vec3 down = unit(cross(centre, right));
    begin_element(Shape::ball, i);
    for (std::size_t corner = 0; corner < kBallCorners; ++corner) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(corner) / kBallCorners;
      vertices_.push_back(add(silhouette, times(outside(kBallCorners) * silhouette_radius,
                                                add(times(std::cos(angle), right), times(std::sin(angle), down)))));
    }
    finish_element(centre.z);
  }
}

void ScenePainter::pose_poles() {
  for (const Pole& pole : scene_.poles()) {
    add_round(Shape::pole, rounds_.size(), in_camera(pole.from_in_world_m), in_camera(pole.to_in_world_m), pole.radius_m,
              pole.radius_m, {.ink = ink_(pole.colour)});
  }
}

void ScenePainter::pose_bar(const std::vector<Vec3>& points) {
  constexpr Colour kAluminium{0.74, 0.75, 0.77};
  const Ink ink = ink_(kAluminium);
  const double radius = scene_.description().bar_rig->bar_diameter_m / 2;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Vec3 step = subtract(points[i + 1], points[i]);
    const int pieces = std::clamp(static_cast<int>(std::ceil(length(step) / kBarPiece_m)), 1, 100);
    for (int piece = 0; piece < pieces; ++piece) {
      const auto at = [&](int n) { return in_camera(add(points[i], times(n / static_cast<double>(pieces), step))); };
      add_round(Shape::pole, rounds_.size(), at(piece), at(piece + 1), radius, radius, {.ink = ink});
    }
  }
}

void ScenePainter::pose_rig(const RigMoment& rig) {
  ROSEAU_CHECK(scene_.description().bar_rig.has_value());
  ROSEAU_CHECK(rig.targets_in_world_m.size() == scene_.front_tags().size());
  pose_bar(rig.long_bar_in_world_m);
  pose_bar(rig.cross_bar_in_world_m);
  const Matrix3 world_from_rig = rotation(rig.world_from_rig);
  for (std::size_t tag = 0; tag < rig.targets_in_world_m.size(); ++tag) add_tag(rig, world_from_rig, tag);
}

// The corners of all cells of the printed picture, row by row from its upper left as seen from the side that is seen.
void ScenePainter::add_tag(const RigMoment& rig, const Matrix3& world_from_rig, std::size_t tag) {
  const Matrix3 camera_from_rig = product(camera_from_world_, world_from_rig);
  const Vec3 centre = in_camera(rig.targets_in_world_m[tag]);
  const Vec3 normal = rotated(camera_from_rig, {0, 0, 1});
  const bool from_behind = dot(normal, centre) > 0;
  const double cell = scene_.description().bar_rig->tag_size_m / (TagPattern::kCells - 2);
  const Vec3 right = rotated(camera_from_rig, {from_behind ? -cell : cell, 0, 0});
  const Vec3 down = rotated(camera_from_rig, {0, -cell, 0});
  constexpr auto kHalf = static_cast<double>(TagPattern::kCells) / 2;
  begin_element(Shape::tag, tag);
  for (std::size_t row = 0; row <= TagPattern::kCells; ++row) {
    for (std::size_t column = 0; column <= TagPattern::kCells; ++column) {
      vertices_.push_back(
          add(centre, add(times(static_cast<double>(column) - kHalf, right), times(static_cast<double>(row) - kHalf, down))));
    }
  }
  // A tag is fixed before its bar on either side: nearer than any piece that crosses it.
  const double nearest = std::abs(right.z) * kHalf + std::abs(down.z) * kHalf;
  finish_element(centre.z - nearest - kBarPiece_m / 2);
  tag_from_behind_.push_back(from_behind);
  tag_lights_.push_back(static_cast<float>(flat_light(from_behind ? times(-1, normal) : normal)));
}

// Four corners of the plate, then the lens of each LED that is there.
void ScenePainter::pose_board() {
  const auto& board = scene_.description().led_board;
  if (!board) return;
  const Matrix3 camera_from_board = product(camera_from_world_, rotation(board->world_from_board));
  const Vec3 centre = in_camera(board->centre_in_world_m);
  // x to the right, y down, from the board's centre.
  const auto at = [&](double x, double y) { return add(centre, rotated(camera_from_board, {x, -y, 0})); };
  const double half_width = (kLedColumns + 0.6) / 2 * board->pitch_m;
  const double half_height = (kLedRows + 0.6) / 2 * board->pitch_m;
  begin_element(Shape::board, 0);
  for (const auto& [x, y] : {Vec2{-1, -1}, Vec2{1, -1}, Vec2{1, 1}, Vec2{-1, 1}})
    vertices_.push_back(at(x * half_width, y * half_height));
  const double radius = board->led_diameter_m / 2 * outside(kLedCorners);
  for (std::size_t row = 0; row < kLedRows; ++row) {
    for (std::size_t column = 0; column < kLedColumns; ++column) {
      const double x = (static_cast<double>(column) - (kLedColumns - 1) / 2.0) * board->pitch_m;
      const double y = (static_cast<double>(row) - (kLedRows - 1) / 2.0) * board->pitch_m;
      for (std::size_t corner = 0; corner < kLedCorners; ++corner) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(corner) / kLedCorners;
        vertices_.push_back(at(x + radius * std::cos(angle), y + radius * std::sin(angle)));
      }
    }
  }
  finish_element(centre.z);
}

void ScenePainter::project_vertices() {
  projected_.resize(vertices_.size());
  image_.resize(vertices_.size());
  projection_.project_in_camera(vertices_, projected_);
  for (std::size_t i = 0; i < projected_.size(); ++i) {
    image_[i] = {static_cast<float>(projected_[i].x), static_cast<float>(projected_[i].y)};
  }
}

// The order hardly changes from one frame to the next: insertion takes next to no time then. Equal depths go by index, so that
// the order depends on this moment only.
void ScenePainter::sort_elements() {
  const auto before = [this](std::uint32_t a, std::uint32_t b) {
    return depths_m_[a] != depths_m_[b] ? depths_m_[a] > depths_m_[b] : a < b;
  };
  if (order_.size() != elements_.size()) {
    order_.resize(elements_.size());
    std::iota(order_.begin(), order_.end(), 0U);
    std::ranges::sort(order_, before);
    return;
  }
  for (std::size_t i = 1; i < order_.size(); ++i) {
    const std::uint32_t element = order_[i];
    std::size_t place = i;
    for (; place > 0 && before(element, order_[place - 1]); --place) order_[place] = order_[place - 1];
    order_[place] = element;
  }
}

double ScenePainter::flat_light(const Vec3& normal_in_camera) const {
  return double{ambient_} + double{sun_} * std::max(0.0, dot(normal_in_camera, sun_in_camera_));
}

}  // namespace roseau::render
