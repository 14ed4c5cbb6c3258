// VisibleScene: a SceneDescription prepared for drawing: shapes of leaves, light that reaches them, textures. Built once,
// immutable, shared by the renderers of all cameras.
#pragma once

#include <memory>
#include <vector>

#include "core/result.h"
#include "synthesis/render/foliage.h"
#include "synthesis/render/landscape.h"
#include "synthesis/render/scene_description.h"
#include "synthesis/render/scene_moment.h"
#include "synthesis/render/tag_pattern.h"

namespace roseau::render {

/// A straight piece of round, smooth material that does not move.
struct Pole {
  Vec3 from_in_world_m;
  Vec3 to_in_world_m;
  double radius_m = 0;
  Colour colour;
};

class VisibleScene {
 public:
  /// Refuses a ball on a node that does not exist, tags that the family does not have, sizes that are not positive.
  static Result<std::shared_ptr<const VisibleScene>> create(SceneDescription description);

  const SceneDescription& description() const { return description_; }
  const structure::TreeModel& tree() const { return description_.tree; }
  const std::vector<VisibleLeaf>& leaves() const { return leaves_; }
  const Landscape& landscape() const { return landscape_; }
  /// Per node: share of the sun that reaches its segment.
  const std::vector<float>& wood_sunlight() const { return wood_sunlight_; }
  const std::vector<Pole>& poles() const { return poles_; }
  /// Unit vector.
  const Vec3& to_sun() const { return to_sun_; }
  const std::vector<TagPattern>& front_tags() const { return front_tags_; }
  const std::vector<TagPattern>& back_tags() const { return back_tags_; }

  /// A moment of this scene at rest, its vectors of the right size.
  SceneMoment rest() const;

  /// Where the centre of a ball is: the truth that pictures show.
  Vec3 ball_in_world(const SceneMoment& moment, std::size_t ball) const;

 private:
  VisibleScene(SceneDescription description, std::vector<TagPattern> front_tags, std::vector<TagPattern> back_tags);

  SceneDescription description_;
  Vec3 to_sun_;
  std::vector<VisibleLeaf> leaves_;
  std::vector<float> wood_sunlight_;
  std::vector<Pole> poles_;
  Landscape landscape_;
  std::vector<TagPattern> front_tags_;
  std::vector<TagPattern> back_tags_;
};

}  // namespace roseau::render
