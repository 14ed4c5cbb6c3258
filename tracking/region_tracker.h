// RegionTracker: follows one region of the picture (a target, or the background) by many points.
//
// Per frame: flow carries every point over from the previous picture; from there each point is found again by its own
// reference patch, which cannot drift. Two robust fits follow: how the points seen in both pictures moved since the previous
// one (the step), and where all points seen are against the reference. The step does not jump when points come and go, but
// adds up its errors; the other does not drift, but jumps. A Kalman filter blends the two by their measured covariances.
//
// Pixel coordinates have their origin at the CENTRE of the upper left pixel. A target's displacement is relative to the
// background, where a camera motion is given.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/geometry.h"
#include "tracking/checkpoint.h"
#include "tracking/coarse_search.h"
#include "tracking/feature_set.h"
#include "tracking/flow.h"
#include "tracking/options.h"
#include "tracking/placement.h"
#include "tracking/region_motion.h"
#include "tracking/work.h"

namespace roseau::tracking {

class RegionTracker {
 public:
  RegionTracker(const TrackerOptions& options, std::string name, RegionKind kind);

  /// Makes the current picture of `flow` the reference: displacement is zero there. At most `count` points, out of
  /// `keep_out`. False: fewer points than a motion can be told from; the region stays lost.
  bool start(const Flow& flow, const ImageRect& region, int count, std::span<const ImageRect> keep_out,
             const CameraMotion& camera);

  /// Appends the points to be followed; update() is given the same ones back, carried into the current picture.
  void collect(std::vector<FlowPoint>& points) const;
  /// `camera`: the background's motion in the current picture; identity where it is not known or not to be taken off.
  void update(std::span<const FlowPoint> points, const Flow& flow, const CameraMotion& camera);
  /// After update(): replaces points that were lost for good, now and then, when that is due.
  void replenish(const Flow& flow, std::span<const ImageRect> keep_out);
  void limit(int count) { features_.limit(count); }
  /// How many points it has, or would have if none had been lost.
  int wanted() const { return features_.wanted(); }
  void drop_inside(const ImageRect& area) { features_.drop_inside(area); }

  const std::string& name() const { return name_; }
  const Placement& placement() const { return placement_; }
  /// Relative to the background, px.
  Eigen::Vector2d displacement() const { return placement_.motion.displacement; }
  /// Of displacement(), from the scatter of the points; the camera motion's own is not in it.
  Eigen::Matrix2d covariance() const;
  /// False: start() found too few points; it may be called again.
  bool started() const { return started_; }
  bool valid() const { return valid_; }
  int agreeing() const { return agreeing_; }
  float health() const;
  std::span<const Feature> features() const { return features_.all(); }
  /// Where the region is in the current picture.
  ImageRect region_now() const;
  void observe_work(WorkObserver* observer) { observer_ = observer; }

  void save(CheckpointWriter& out) const;
  /// Restores what save() wrote. Bytes that cannot be right fail the reader.
  void load(CheckpointReader& in);

 private:
  enum class Among { followed, matched };

  RegionPoint from_reference(const Feature& feature) const;
  RegionPoint from_previous(const Feature& feature) const;
  bool is_seen() const;
  int least_matched() const;
  int least_agreeing(int matched) const;
  void watch_unrest();
  bool counts(const Feature& feature) const;
  void fit_step(Among among);
  void fit_reference();
  void judge();
  void blend();
  void look_for(const Flow& flow);
  bool try_at(const Eigen::Vector2d& displacement, const Flow& flow);
  void count_still();
  void enters(Work work) const {
    if (observer_ != nullptr) observer_->enters(work);
  }

  TrackerOptions options_;
  std::string name_;
  RegionKind kind_;
  WorkObserver* observer_ = nullptr;

  ImageRect region_;  // in the reference picture
  std::uint32_t reference_count_ = 0;
  FeatureSet features_;
  Placement placement_;
  RegionMotion last_step_;
  Eigen::Matrix2d covariance_ = Eigen::Matrix2d::Zero();     // of the filter; what its reference itself is off comes on top:
  double reference_variance_ = 0;                            // 0 while it rests on points of the reference picture
  Eigen::Vector2d camera_before_ = Eigen::Vector2d::Zero();  // the camera's part at the centre, in the previous picture
  bool started_ = false;
  bool valid_ = false;
  std::int32_t matched_ = 0;
  std::int32_t agreeing_ = 0;
  std::uint32_t frame_ = 0;
  std::uint32_t frames_lost_ = 0;

  // Working memory, not state.
  RegionFitter fitter_;
  RegionFit step_;       // this frame's fit of motion since the previous picture, the camera's included
  RegionFit reference_;  // and of displacement from the reference
  std::vector<RegionPoint> fit_points_;
  std::vector<double> unrests_px2_;  // scratch
  double most_unrest_px2_ = 0;       // of the background's points that tell of the camera
  std::vector<CoarseProbe> probes_;
};

}  // namespace roseau::tracking
