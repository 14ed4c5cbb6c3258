// ScenePainter: draws all that stands before the backdrop, the farthest first.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "calib/model/projection.h"
#include "synthesis/render/coverage.h"
#include "synthesis/render/led_schedule.h"
#include "synthesis/render/picture.h"
#include "synthesis/render/vector_math.h"
#include "synthesis/render/visible_scene.h"

namespace roseau::render {

/// What the LED board shows: board time at the start of the exposure of row 0, in ticks; per row; and the exposure's length.
struct BoardExposure {
  double start_ticks = 0;
  double ticks_per_row = 0;
  double duration_ticks = 1;
};

class ScenePainter {
 public:
  ScenePainter(const VisibleScene& scene, const calib::Projection& projection, const InkMaker& ink);

  /// Puts everything where it is at a moment, as seen by the camera.
  void pose(const SceneMoment& moment, const BoardExposure& exposure);

  /// Draws it into a part of the picture.
  void draw(Coverage& coverage, Picture& picture, const PixelArea& clip);

 private:
  static constexpr int kBarkAround = 32;  // texture
  static constexpr int kBarkAlong = 256;
  static constexpr float kBarkPerMetre = 96;
  static constexpr std::size_t kLedCorners = 16;

  enum class Shape : std::uint8_t { leaf, wood, ball, pole, board, tag };

  struct Element {
    Shape shape = Shape::leaf;
    bool seen = true;
    std::uint32_t index = 0;  // of the leaf, segment, ball, ...
    std::uint32_t first_vertex = 0;
    std::uint32_t vertex_count = 0;
  };

  // A piece of round wood, steel or wire: how light falls on it.
  struct Round {
    Ink ink{};
    float sun_across = 0;  // the sun's direction in the piece's frame: to its left, and towards the camera
    float sun_facing = 0;
    float sunlight = 1;
    float along_m = 0;  // where its texture begins
    float length_m = 0;
    bool bark = false;
  };

  struct LeafLight {
    Ink left{};  // the two halves of the blade
    Ink right{};
  };

  void pose_nodes(const SceneMoment& moment);
  void pose_leaves();
  void pose_wood();
  void pose_balls();
  void pose_poles();
  void pose_board();
  void pose_rig(const RigMoment& rig);
  void pose_bar(const std::vector<Vec3>& points_in_world_m);
  void add_tag(const RigMoment& rig, const Matrix3& world_from_rig, std::size_t tag);
  void add_round(Shape shape, std::size_t index, const Vec3& from, const Vec3& to, double from_radius_m, double to_radius_m,
                 Round round);
  void begin_element(Shape shape, std::size_t index);
  void finish_element(double depth_m);
  void project_vertices();
  void sort_elements();

  void draw_leaf(const Element& element, Coverage& coverage, Picture& picture, const PixelArea& clip) const;
  void draw_round(const Element& element, const Round& round, Coverage& coverage, Picture& picture,
                  const PixelArea& clip) const;
  void draw_ball(const Element& element, Coverage& coverage, Picture& picture, const PixelArea& clip) const;
  void draw_board(const Element& element, Coverage& coverage, Picture& picture, const PixelArea& clip) const;
  void draw_tag(const Element& element, Coverage& coverage, Picture& picture, const PixelArea& clip) const;
  void draw_led(std::span<const ImagePoint> outline, std::size_t row, std::size_t column, Coverage& coverage, Picture& picture,
                const PixelArea& clip) const;

  Vec3 in_camera(const Vec3& point_in_world) const;
  LeafLight light_on(const VisibleLeaf& leaf, const Vec3& normal, const Vec3& at) const;
  double flat_light(const Vec3& normal_in_camera) const;

  const VisibleScene& scene_;
  const calib::Projection& projection_;
  InkMaker ink_;
  Matrix3 camera_from_world_;
  Vec3 sun_in_camera_;
  float ambient_;
  float sun_;
  std::array<std::array<Ink, 256>, 4> greens_;  // per tint, by how brightly a leaf is lit
  std::vector<Ink> ball_inks_;
  std::vector<float> bark_;  // kBarkAround x kBarkAlong: brightness, mean 1

  std::vector<Matrix3> camera_from_node_;  // turns of each node
  std::vector<Vec3> node_in_camera_;
  BoardExposure exposure_;
  float light_level_ = 1;

  std::vector<Element> elements_;
  std::vector<float> depths_m_;
  std::vector<std::uint32_t> order_;  // of elements_, the farthest first
  std::vector<Vec3> vertices_;        // in the camera's frame
  std::vector<Vec2> projected_;
  std::vector<ImagePoint> image_;
  std::vector<LeafLight> leaf_lights_;
  std::vector<Round> rounds_;  // of all wood, poles and bars
  std::vector<bool> tag_from_behind_;
  std::vector<float> tag_lights_;
};

}  // namespace roseau::render
