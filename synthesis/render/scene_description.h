// What stands in front of the cameras. World frame: metres, x east, y north, z up, origin at the foot of the tree; the cameras
// stand south and look north.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry.h"
#include "structure/tree/tree_model.h"
#include "synthesis/render/colour.h"

namespace roseau::render {

/// A matt ball fixed to a node of the tree.
struct MarkerBall {
  std::uint32_t node = 0;
  Vec3 offset_m;  // of its centre from the node, at rest, in world axes; it turns with the node
  double diameter_m = 0.10;
  Colour colour;
};

/// The four colours that stand out from leaves and from each other.
inline constexpr std::array<Colour, 4> kMarkerColours{
    {{0.93, 0.10, 0.08}, {0.10, 0.25, 0.95}, {0.98, 0.88, 0.05}, {1.00, 0.48, 0.02}}};  // red, blue, yellow, orange

/// The board of LEDs that shows its own clock (led_schedule.h has its layout).
struct LedBoard {
  Vec3 centre_in_world_m;
  /// Board's axes: x to the right and y up as one looks at its face, z out of the face. The default faces south.
  Quaternion world_from_board{0.70710678118654752, 0.70710678118654752, 0, 0};
  double pitch_m = 0.05;         // between neighbouring LEDs
  double led_diameter_m = 0.03;  // of its lens
  double tick_duration_s = 0.0005;
  std::uint8_t board_id = 5;  // 4 bits
  bool synchronised = true;   // its controller has a valid fit to the host's clock
  /// What an LED adds to its picture while it is lit, in full scales of the camera. The fine ring's LEDs are lit for one tick
  /// only and driven that much harder.
  double brightness = 0.75;
  double fine_ring_brightness = 6.0;
};

/// The calibration rig: a long bar and a cross bar with AprilTags of family 36h11. Where its bars and targets are at a time
/// comes with the SceneMoment.
struct BarRig {
  /// Rig's axes: x along the long bar, y along the cross bar, z out of the tags' front. Seen from the front with x to the right
  /// and y up, the tags stand upright.
  double bar_diameter_m = 0.04;
  double tag_size_m = 0.30;  // the black square, without its white border of one eighth
  std::vector<int> front_tags{0, 1, 2, 3, 4, 5};
  std::vector<int> back_tags;  // empty, or as many as in front: same centres, seen from behind
};

/// A sonic anemometer on a mast.
struct SonicMast {
  Vec3 position_in_world_m;  // centre of its measuring volume
};

struct Lighting {
  Vec3 to_sun{-0.50, -0.55, 0.67};  // need not be of unit length
  double sun = 0.75;                // direct light; 0: an overcast sky, without shading
  double ambient = 0.45;
};

struct Background {
  bool visible = true;  // false: uniformly `plain`
  Colour plain{0.5, 0.5, 0.5};
  double hedge_sway_m = 0.05;  // amplitude at the hedge's top while the moment's background_sway is 1
  double cloud_speed_mps = 8;  // at 1000 m height, from west to east
};

struct SceneDescription {
  structure::TreeModel tree;
  std::vector<MarkerBall> balls;
  std::optional<LedBoard> led_board;
  std::optional<BarRig> bar_rig;
  std::optional<SonicMast> sonic;
  Lighting lighting;
  Background background;
  /// Where cameras stand: leaves that would hide a ball from one of these points at rest are left out, as an experimenter
  /// would pick them. A leaf counts as hiding when it comes nearer to the line of sight than `clearance_m` beyond the ball's
  /// radius.
  std::vector<Vec3> viewpoints_in_world_m;
  double clearance_m = 0.10;
  std::uint64_t seed = 1;
};

}  // namespace roseau::render
