// FeatureSet: the points of one region through their lives: found, followed, matched, lost, found again, replaced.
//
// Points of the region's first picture (generation 0) are kept even when they are not seen: while inactive they are looked
// for where they should be, because only they tie the region to its reference without error. Points that replace them are
// dropped as soon as they fail while the region itself is seen.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "tracking/checkpoint.h"
#include "tracking/feature.h"
#include "tracking/flow.h"
#include "tracking/options.h"
#include "tracking/placement.h"

namespace roseau::tracking {

enum class RegionKind : std::uint8_t { target, background };

class FeatureSet {
 public:
  FeatureSet(const TrackerOptions& options, RegionKind kind) : options_(options), kind_(kind) {}

  std::span<Feature> all() { return features_; }
  std::span<const Feature> all() const { return features_; }
  int wanted() const { return static_cast<int>(wanted_); }
  int active_count() const;

  /// Finds at most `count` points inside `area` and out of `keep_out` in the current picture and makes them generation 0.
  void start(const Flow& flow, const ImageRect& area, int count, std::span<const ImageRect> keep_out,
             const Placement& placement);

  /// Appends the active points with the places they are expected at after `step`.
  void collect(std::vector<FlowPoint>& points, const RegionMotion& step, const Eigen::Vector2d& centre) const;
  /// Takes back what collect() gave, after Flow::follow().
  void carry_over(std::span<const FlowPoint> points);

  /// Looks for the active points' patches. `step` helps those that flow lost; null: they are looked for at their place.
  void match_active(const Flow& flow, const Placement& placement, const RegionMotion* step);
  /// Looks for the inactive points' patches at their places: a quarter of them in a frame.
  void match_inactive(const Flow& flow, const Placement& placement, std::uint32_t frame);
  /// Looks for all points around their places, by coarse patches first where they have them: the region was lost.
  void match_all_afresh(const Flow& flow, const Placement& placement);

  /// Points that were not matched for the second time but move along get a successor with today's look. `variance` is what
  /// that costs. Points of generation 0 themselves become inactive: their look may come back.
  void hand_over(const Flow& flow, const Placement& placement, double variance);

  /// Ends a frame: counts, gives up, puts unmatched points where they should be. `region_seen`: the placement is that of
  /// this frame, not a held one.
  void keep_or_drop(const Placement& placement, bool region_seen);
  /// Gives up points that have stood still often enough while the region moved, and remembers their places. Returns how
  /// many of them were of generation 0.
  int drop_still();
  void forget_matches();

  /// Looks for new points in `area` when many are missing; not more often than worth it. `variance` is that of the
  /// placement: new points cannot know their reference better.
  void replenish(const Flow& flow, const ImageRect& area, std::span<const ImageRect> keep_out, const Placement& placement,
                 double variance, std::uint32_t frame);
  /// No more than `count` points from now on; the least useful beyond it go.
  void limit(int count);
  void drop_inside(const ImageRect& area);

  void save(CheckpointWriter& out) const;
  void load(CheckpointReader& in);

 private:
  void drop_surplus();
  void add(std::vector<Feature> found, const Placement& placement, std::uint16_t generation, double variance);

  TrackerOptions options_;
  RegionKind kind_;
  std::vector<Feature> features_;
  std::vector<Eigen::Vector2d> still_places_;  // in the reference picture: background seen through the target
  std::uint32_t wanted_ = 0;
  std::uint32_t next_id_ = 0;
  std::uint32_t renewal_due_ = 0;  // frame from which new points may be looked for
  std::uint32_t renewal_wait_ = 0;
  std::uint32_t renewal_cell_ = 0;
};

}  // namespace roseau::tracking
