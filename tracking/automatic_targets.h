// AutomaticTargets: watches points all over the picture for a while and groups those that move, near each other and
// together, into targets.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "core/geometry.h"
#include "tracking/checkpoint.h"
#include "tracking/feature.h"
#include "tracking/options.h"
#include "tracking/placement.h"

namespace roseau::tracking {

class AutomaticTargets {
 public:
  explicit AutomaticTargets(const TrackerOptions& options) : options_(options) {}

  /// One frame: the points of the whole picture and the camera's motion.
  void observe(std::span<const Feature> features, const CameraMotion& camera);
  bool complete() const { return static_cast<int>(frames_) >= options_.automatic_frames; }

  /// The regions found, most telling first (points times motion), none overlapping much; positions of the last frame, px
  /// with the origin at the CENTRE of the upper left pixel. Watching starts anew. Empty: nothing moved enough.
  std::vector<ImageRect> choose();

  void save(CheckpointWriter& out) const;
  void load(CheckpointReader& in);

 private:
  struct Track {
    std::vector<Eigen::Vector2f> displacement;  // per frame, camera's motion taken off
    std::uint32_t matched = 0;                  // frames
    Eigen::Vector2f position{0, 0};             // last
  };

  TrackerOptions options_;
  std::uint32_t frames_ = 0;
  std::map<std::uint32_t, Track> tracks_;  // by feature id: ordered, so that the outcome is too
};

}  // namespace roseau::tracking
