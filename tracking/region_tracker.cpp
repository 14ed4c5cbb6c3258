#include "tracking/region_tracker.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace roseau::tracking {

namespace {

constexpr int kLeastPoints = 4;
constexpr double kLeastShare = 0.25;     // of the reference's points, for a region to count as seen
constexpr std::uint16_t kProbation = 5;  // frames a new point has to agree before it counts

// Least scatter of one point, px: of flow between two pictures and of a match with the reference.
constexpr double kFlowNoise = 0.04;
constexpr double kMatchNoise = 0.04;
// What the sum of steps loses per frame beyond the scatter seen, px: points on one thing err together.
constexpr double kStepFloor = 0.003;
constexpr double kReferenceFloor = 0.003;
// What it costs, px, to hand the reference on to new points: those that go are changing their look, and err together.
constexpr double kHandOver = 0.05;
constexpr double kSurprise = 3;       // standard deviations: the filter's own idea is given up beyond
constexpr double kLostGrowth = 1;     // px of standard deviation added in quadrature by every frame not seen
constexpr double kCameraUnknown = 1;  // px: how far a camera on a stand is taken to move while nothing tells

// The camera's motion is that of the calmest points: foliage that is no target moves, too, and often fills the picture.
constexpr double kCalmShare = 0.3;              // of the background's points
constexpr double kCalmFactor = 4;               // against the most restless one of that share
constexpr double kCalmFloor_px2 = 0.05 * 0.05;  // steps as small as flow's own scatter
constexpr std::uint16_t kUnrestFrames = 90;

constexpr double kStill = 0.3;   // px from the reference: standing still
constexpr double kMoving = 1.0;  // px from the reference: moving

constexpr std::uint32_t kSearchAfter = 5;  // frames lost
constexpr std::uint32_t kSearchEvery = 3;  // frames
constexpr std::size_t kMostProbes = 24;

Eigen::Matrix2d squared(double sd) { return Eigen::Matrix2d::Identity() * (sd * sd); }

}  // namespace

RegionTracker::RegionTracker(const TrackerOptions& options, std::string name, RegionKind kind)
    : options_(options), name_(std::move(name)), kind_(kind), features_(options, kind) {}

bool RegionTracker::start(const Flow& flow, const ImageRect& region, int count, std::span<const ImageRect> keep_out,
                          const CameraMotion& camera) {
  placement_ = Placement{.camera = camera};
  const Eigen::Vector2d half(region.width / 2, region.height / 2);
  placement_.centre = placement_.reference_of(Eigen::Vector2d(region.x, region.y) + half);
  region_ = {placement_.centre.x() - half.x(), placement_.centre.y() - half.y(), region.width, region.height};
  features_.start(flow, region, count, keep_out, placement_);
  reference_count_ = static_cast<std::uint32_t>(features_.wanted());
  started_ = valid_ = reference_count_ >= kLeastPoints;
  matched_ = agreeing_ = static_cast<int>(reference_count_);
  last_step_ = {};
  covariance_.setZero();
  reference_variance_ = 0;
  camera_before_ = camera.at(placement_.centre);
  frame_ = frames_lost_ = 0;
  return valid_;
}

int RegionTracker::least_matched() const {
  const int present = std::min(static_cast<int>(reference_count_), features_.wanted());
  const double share = kind_ == RegionKind::background ? kLeastShare * kCalmShare : kLeastShare;
  return std::max(kLeastPoints, static_cast<int>(std::ceil(share * present)));
}

/// Leaves of a crown do not all move alike: that fewer agree than are seen does not make the crown lost.
int RegionTracker::least_agreeing(int matched) const {
  return std::max(kLeastPoints, static_cast<int>(std::ceil(kLeastShare * matched)));
}

bool RegionTracker::is_seen() const {
  return reference_.found && matched_ >= least_matched() && agreeing_ >= least_agreeing(matched_);
}

Eigen::Matrix2d RegionTracker::covariance() const { return covariance_ + Eigen::Matrix2d::Identity() * reference_variance_; }

float RegionTracker::health() const {
  const int present = std::min(features_.wanted(), static_cast<int>(features_.all().size()));
  return present == 0 ? 0.0F : std::min(1.0F, static_cast<float>(agreeing_) / static_cast<float>(present));
}

ImageRect RegionTracker::region_now() const {
  const Eigen::Vector2d moved = placement_.expected(placement_.centre) - placement_.centre;
  return {region_.x + moved.x(), region_.y + moved.y(), region_.width, region_.height};
}

void RegionTracker::collect(std::vector<FlowPoint>& points) const { features_.collect(points, last_step_, placement_.centre); }

void RegionTracker::update(std::span<const FlowPoint> points, const Flow& flow, const CameraMotion& camera) {
  ++frame_;
  placement_.camera = camera;
  enters(Work::robust);
  features_.carry_over(points);
  watch_unrest();
  fit_step(Among::followed);
  enters(Work::patches);
  features_.match_active(flow, placement_, step_.found ? &step_.motion : nullptr);
  features_.match_inactive(flow, placement_, frame_);
  enters(Work::robust);
  fit_step(Among::matched);
  fit_reference();
  judge();

  if (is_seen()) {
    blend();
    features_.hand_over(flow, placement_, kHandOver * kHandOver);
  } else {
    valid_ = false;
    ++frames_lost_;
    const double most = kind_ == RegionKind::background ? kCameraUnknown : options_.search_radius_px;
    if (covariance_.trace() < 2 * most * most) covariance_ += squared(kLostGrowth);
    if (frames_lost_ >= kSearchAfter && frames_lost_ % kSearchEvery == 0) look_for(flow);
  }
  last_step_ = valid_ && step_.found ? step_.motion : RegionMotion{};
  camera_before_ = camera.at(placement_.centre);
  count_still();
  features_.keep_or_drop(placement_, valid_);
  reference_count_ -= std::min(reference_count_, static_cast<std::uint32_t>(features_.drop_still()));
}

RegionPoint RegionTracker::from_previous(const Feature& feature) const {
  return {feature.reference - placement_.centre, feature.position - feature.previous};
}

void RegionTracker::watch_unrest() {
  if (kind_ != RegionKind::background) return;
  unrests_px2_.clear();
  for (Feature& feature : features_.all()) {
    if (!feature.active || !feature.followed) continue;
    feature.watched = std::min<std::uint16_t>(feature.watched + 1, kUnrestFrames);
    feature.unrest_px2 += ((feature.position - feature.previous).squaredNorm() - feature.unrest_px2) / feature.watched;
    unrests_px2_.push_back(feature.unrest_px2);
  }
  if (unrests_px2_.empty()) return;
  const auto calm =
      unrests_px2_.begin() + static_cast<std::ptrdiff_t>(kCalmShare * static_cast<double>(unrests_px2_.size() - 1));
  std::ranges::nth_element(unrests_px2_, calm);
  most_unrest_px2_ = kCalmFactor * std::max(*calm, kCalmFloor_px2);
}

/// Does it tell how the region moves?
bool RegionTracker::counts(const Feature& feature) const {
  return kind_ != RegionKind::background || feature.unrest_px2 <= most_unrest_px2_;
}

/// How the region moved since the previous picture, from points that agreed with it there.
void RegionTracker::fit_step(Among among) {
  fit_points_.clear();
  for (const Feature& feature : features_.all()) {
    if (!feature.active || !feature.followed || !feature.agrees || !counts(feature)) continue;
    if (among == Among::matched && !feature.matched) continue;
    fit_points_.push_back(from_previous(feature));
  }
  step_ = fitter_.fit(fit_points_, last_step_.gradient, kFlowNoise);
  step_.found = step_.found && step_.agreeing >= kLeastPoints;
}

RegionPoint RegionTracker::from_reference(const Feature& feature) const {
  return {feature.reference - placement_.centre,
          feature.position - feature.reference - placement_.camera.at(feature.reference)};
}

/// Displacement from the reference: by points of the reference picture while enough are seen, else with those that
/// replaced them, whose own error then counts.
void RegionTracker::fit_reference() {
  const auto seen_of_reference =
      std::ranges::count_if(features_.all(), [](const Feature& f) { return f.matched && f.generation == 0; });
  const bool reference_only = seen_of_reference >= least_matched();
  fit_points_.clear();
  reference_variance_ = 0;
  for (const Feature& feature : features_.all()) {
    if (!feature.matched || !counts(feature)) continue;
    if (feature.generation > 0 && (reference_only || feature.agreed < kProbation)) continue;
    fit_points_.push_back(from_reference(feature));
    reference_variance_ = std::max(reference_variance_, feature.reference_variance);
  }
  reference_ = fitter_.fit(fit_points_, placement_.motion.gradient, kMatchNoise);
}

void RegionTracker::judge() {
  matched_ = agreeing_ = 0;
  for (Feature& feature : features_.all()) {
    feature.agrees = feature.matched && reference_.found && reference_.holds_for(from_reference(feature));
    feature.moves_along = feature.followed && step_.found && step_.holds_for(from_previous(feature));
    if (feature.matched && counts(feature)) ++matched_;
    if (feature.agrees && counts(feature)) ++agreeing_;
  }
}

void RegionTracker::blend() {
  const Eigen::Matrix2d reference_covariance = reference_.covariance + squared(kReferenceFloor);
  if (valid_ && step_.found) {
    const Eigen::Vector2d camera_step = placement_.camera.at(placement_.centre) - camera_before_;
    const Eigen::Vector2d predicted = displacement() + step_.motion.displacement - camera_step;
    Eigen::Matrix2d predicted_covariance = covariance_ + step_.covariance + squared(kStepFloor);
    const Eigen::Vector2d innovation = reference_.motion.displacement - predicted;
    if (mahalanobis2(innovation, (predicted_covariance + reference_covariance).inverse()) > kSurprise * kSurprise) {
      predicted_covariance += innovation * innovation.transpose();
    }
    const Eigen::Matrix2d gain = predicted_covariance * (predicted_covariance + reference_covariance).inverse();
    placement_.motion.displacement = predicted + gain * innovation;
    covariance_ = (Eigen::Matrix2d::Identity() - gain) * predicted_covariance;
    covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
  } else {
    placement_.motion.displacement = reference_.motion.displacement;
    covariance_ = reference_covariance;
  }
  placement_.motion.gradient = reference_.motion.gradient;
  valid_ = true;
  frames_lost_ = 0;
}

/// A lost region: box matching around its last place, then its place at rest.
void RegionTracker::look_for(const Flow& flow) {
  if (kind_ == RegionKind::background || flow.levels() < kCoarseLevel) return;
  probes_.clear();
  const auto all = features_.all();
  const std::size_t every = all.size() / kMostProbes + 1;
  const Placement held = placement_;
  for (std::size_t i = 0; i < all.size(); i += every) {
    if (!all[i].coarse) continue;
    const Eigen::Vector2d at = all[i].coarse_centre(held.expected(all[i].reference));
    probes_.push_back({&*all[i].coarse, at.array().round().matrix().cast<int>()});
  }
  constexpr double kScale = 1 << kCoarseLevel;
  const CoarseShift found =
      coarse_search(flow.current(kCoarseLevel), probes_, static_cast<int>(std::ceil(options_.search_radius_px / kScale)));
  const Eigen::Vector2d candidate = held.motion.displacement + kScale * found.shift.cast<double>();
  if (try_at(candidate, flow) || try_at(Eigen::Vector2d::Zero(), flow)) return;
  placement_ = held;
  features_.forget_matches();
}

bool RegionTracker::try_at(const Eigen::Vector2d& displacement, const Flow& flow) {
  placement_.motion.displacement = displacement;
  features_.match_all_afresh(flow, placement_);
  fit_reference();
  judge();
  if (!is_seen()) return false;
  valid_ = false;
  blend();
  return true;
}

/// Points that stand still while the region moves belong to the background behind it. The region's motion is that of the
/// greater part of its points, or of a good part that moves while the greater part stands still.
void RegionTracker::count_still() {
  if (kind_ == RegionKind::background || !valid_) return;
  RegionMotion moving = placement_.motion;
  if (displacement().norm() < kStill) {
    fit_points_.clear();
    for (const Feature& feature : features_.all()) {
      if (feature.matched && !feature.agrees) fit_points_.push_back(from_reference(feature));
    }
    if (static_cast<int>(fit_points_.size()) < least_agreeing(matched_)) return;
    const RegionFit& minority = fitter_.fit(fit_points_, moving.gradient, kMatchNoise);
    if (!minority.found || minority.agreeing < least_agreeing(matched_)) return;
    moving = minority.motion;
  }
  if (moving.displacement.norm() < kMoving) return;
  for (Feature& feature : features_.all()) {
    if (!feature.matched) continue;
    const RegionPoint point = from_reference(feature);
    const bool stands = point.displacement.norm() < kStill && moving.at(point.offset).norm() > kMoving;
    feature.still = stands ? static_cast<std::uint16_t>(feature.still + 1) : std::uint16_t{0};
  }
}

void RegionTracker::replenish(const Flow& flow, std::span<const ImageRect> keep_out) {
  if (!valid_) return;
  enters(Work::renewal);
  const double variance = 0.5 * covariance().trace() + kHandOver * kHandOver;
  features_.replenish(flow, region_now(), keep_out, placement_, variance, frame_);
}

void RegionTracker::save(CheckpointWriter& out) const {
  for (const double value : {region_.x, region_.y, region_.width, region_.height}) out.put(value);
  out.put(reference_count_);
  features_.save(out);
  out.put(placement_.centre);
  for (const RegionMotion* motion : {&placement_.motion, &placement_.camera.motion, &last_step_}) {
    out.put(motion->displacement);
    out.put(motion->gradient);
  }
  out.put(placement_.camera.centre);
  out.put(placement_.camera.covariance);
  out.put(covariance_);
  out.put(reference_variance_);
  out.put(camera_before_);
  out.put(started_);
  out.put(valid_);
  out.put(matched_);
  out.put(agreeing_);
  out.put(frame_);
  out.put(frames_lost_);
}

void RegionTracker::load(CheckpointReader& in) {
  for (double* value : {&region_.x, &region_.y, &region_.width, &region_.height}) in.get(*value);
  in.get(reference_count_);
  features_.load(in);
  in.get(placement_.centre);
  for (RegionMotion* motion : {&placement_.motion, &placement_.camera.motion, &last_step_}) {
    in.get(motion->displacement);
    in.get(motion->gradient);
  }
  in.get(placement_.camera.centre);
  in.get(placement_.camera.covariance);
  in.get(covariance_);
  in.get(reference_variance_);
  in.get(camera_before_);
  in.get(started_);
  in.get(valid_);
  in.get(matched_);
  in.get(agreeing_);
  in.get(frame_);
  in.get(frames_lost_);
}

}  // namespace roseau::tracking
