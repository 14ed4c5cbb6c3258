#include "synthesis/render/visible_scene.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "synthesis/render/vector_math.h"

namespace roseau::render {

namespace {

Error wrong(const std::string& what) { return {ErrorCode::invalid_argument, fmt::format("scene: {}", what)}; }

Result<void> check_balls(const SceneDescription& description) {
  for (const MarkerBall& ball : description.balls) {
    if (ball.node >= description.tree.nodes.size()) {
      return wrong(fmt::format("a ball is fixed to node {}, the tree has nodes 0 to {}", ball.node,
                               static_cast<long>(description.tree.nodes.size()) - 1));
    }
    if (!(ball.diameter_m > 0)) return wrong("a ball's diameter must be positive");
  }
  return {};
}

Result<void> check_board(const std::optional<LedBoard>& board) {
  if (!board) return {};
  if (!(board->pitch_m > 0 && board->led_diameter_m > 0 && board->led_diameter_m <= board->pitch_m)) {
    return wrong("the LED board's LEDs must have a positive diameter and fit into their pitch");
  }
  if (!(board->tick_duration_s > 0)) return wrong("the LED board's tick must be longer than 0 s");
  if (board->board_id > 15) return wrong(fmt::format("the LED board's id {} does not fit 4 bits (0 to 15)", board->board_id));
  return {};
}

Result<std::vector<TagPattern>> tags(const std::vector<int>& ids) {
  std::vector<TagPattern> patterns;
  for (const int id : ids) {
    const Result<TagPattern> pattern = tag36h11(id);
    if (!pattern) return pattern.error().with_context("scene");
    patterns.push_back(*pattern);
  }
  return patterns;
}

// A three-path anemometer on its mast: a body below, a cap above, three arms that hold the transducers around the volume.
std::vector<Pole> sonic_poles(const SonicMast& sonic) {
  constexpr Colour kSteel{0.42, 0.44, 0.46};
  constexpr Colour kBody{0.80, 0.81, 0.82};
  constexpr Colour kArm{0.22, 0.23, 0.25};
  const Vec3& c = sonic.position_in_world_m;
  const auto at = [&c](double x, double y, double z) { return Vec3{c.x + x, c.y + y, c.z + z}; };
  std::vector<Pole> poles{{{c.x, c.y, 0}, at(0, 0, -0.40), 0.024, kSteel},
                          {at(0, 0, -0.42), at(0, 0, -0.20), 0.045, kBody},
                          {at(0, 0, -0.20), at(0, 0, -0.13), 0.060, kBody},
                          {at(0, 0, 0.13), at(0, 0, 0.18), 0.055, kBody}};
  for (int arm = 0; arm < 3; ++arm) {
    const double angle = 2 * std::numbers::pi * arm / 3 + 0.5;
    const double x = 0.10 * std::cos(angle);
    const double y = 0.10 * std::sin(angle);
    poles.push_back({at(0.5 * x, 0.5 * y, -0.13), at(x, y, -0.08), 0.011, kArm});
    poles.push_back({at(x, y, -0.08), at(x, y, 0.08), 0.009, kArm});
    poles.push_back({at(x, y, 0.08), at(0.5 * x, 0.5 * y, 0.13), 0.011, kArm});
  }
  return poles;
}

}  // namespace

Result<std::shared_ptr<const VisibleScene>> VisibleScene::create(SceneDescription description) {
  if (const Result<void> checked = check_balls(description); !checked) return checked.error();
  if (const Result<void> checked = check_board(description.led_board); !checked) return checked.error();
  if (!(length(description.lighting.to_sun) > 0)) return wrong("the direction to the sun must not be zero");
  const BarRig rig = description.bar_rig.value_or(BarRig{.front_tags = {}});
  if (!rig.back_tags.empty() && rig.back_tags.size() != rig.front_tags.size()) {
    return wrong("the rig needs as many tags on its back as on its front, or none");
  }
  if (!(rig.tag_size_m > 0 && rig.bar_diameter_m > 0)) return wrong("the rig's tags and bars must have a positive size");
  Result<std::vector<TagPattern>> front = tags(rig.front_tags);
  if (!front) return front.error();
  Result<std::vector<TagPattern>> back = tags(rig.back_tags);
  if (!back) return back.error();
  // Not make_shared: the constructor is private.
  return std::shared_ptr<const VisibleScene>(new VisibleScene(std::move(description), std::move(*front), std::move(*back)));
}

VisibleScene::VisibleScene(SceneDescription description, std::vector<TagPattern> front_tags, std::vector<TagPattern> back_tags)
    : description_(std::move(description)),
      to_sun_(unit(description_.lighting.to_sun)),
      landscape_(description_.seed, cast_shadow(description_.tree, to_sun_)),
      front_tags_(std::move(front_tags)),
      back_tags_(std::move(back_tags)) {
  CrownLight light = light_in_crown(description_.tree, to_sun_);
  leaves_ = visible_leaves(description_, light);
  wood_sunlight_ = std::move(light.node_sunlight);
  if (description_.sonic) poles_ = sonic_poles(*description_.sonic);
}

SceneMoment VisibleScene::rest() const {
  SceneMoment moment;
  moment.displacement_m.resize(description_.tree.nodes.size());
  moment.rotation_rad.resize(description_.tree.nodes.size());
  return moment;
}

Vec3 VisibleScene::ball_in_world(const SceneMoment& moment, std::size_t ball) const {
  const MarkerBall& its_ball = description_.balls.at(ball);
  const Vec3& node = description_.tree.nodes[its_ball.node].position_m;
  const Vec3 offset = rotated(rotation(moment.rotation_rad.at(its_ball.node)), its_ball.offset_m);
  return add(add(node, moment.displacement_m.at(its_ball.node)), offset);
}

}  // namespace roseau::render
