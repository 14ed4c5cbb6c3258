#include "tracking/feature_set.h"

#include <Eigen/LU>
#include <algorithm>

namespace roseau::tracking {

namespace {

constexpr double kMostShiftFollowed = 2;              // px from where flow put a point to where its patch matches
constexpr double kMostShiftExpected = 4;              // px from where a point should be
constexpr double kMostShiftCoarse = 3;                // px at kCoarseLevel
constexpr std::uint16_t kMissedUntilLost = 3;         // frames
constexpr std::uint16_t kDisagreedUntilLost = 5;      // frames, points that replaced others
constexpr std::uint16_t kDisagreedUntilUseless = 90;  // frames, points of the reference picture
constexpr std::uint16_t kStillUntilBackground = 10;   // frames
constexpr double kStrayed = 3;                        // px: an unmatched point this far from its place is put back
constexpr std::uint16_t kCountMost = 60000;
constexpr std::size_t kMostStillPlaces = 500;

constexpr double kRenewBelow = 0.7;         // of the points wanted
constexpr std::uint32_t kRenewalWait = 15;  // frames
constexpr std::uint32_t kRenewalWaitMost = 240;
constexpr std::uint32_t kCellsAcross = 4;  // the background is renewed cell by cell, which bounds the time of one frame
constexpr std::uint32_t kCellsDown = 3;

void count_up(std::uint16_t& counter) {
  if (counter < kCountMost) ++counter;
}

Eigen::Vector2d eigen(const cv::Point2f& point) { return {point.x, point.y}; }
cv::Point2f point2f(const Eigen::Vector2d& vector) { return {static_cast<float>(vector.x()), static_cast<float>(vector.y())}; }

ImageRect cell_of(const ImageRect& area, std::uint32_t cell) {
  const double width = area.width / kCellsAcross;
  const double height = area.height / kCellsDown;
  return {area.x + width * (cell % kCellsAcross), area.y + height * (cell / kCellsAcross % kCellsDown), width, height};
}

bool contains(const ImageRect& area, const Eigen::Vector2d& at) {
  return at.x() >= area.x && at.y() >= area.y && at.x() < area.x + area.width && at.y() < area.y + area.height;
}

}  // namespace

int FeatureSet::active_count() const {
  return static_cast<int>(std::ranges::count_if(features_, [](const Feature& feature) { return feature.active; }));
}

void FeatureSet::add(std::vector<Feature> found, const Placement& placement, std::uint16_t generation, double variance) {
  const Eigen::Matrix2d unwarp = placement.warp().inverse();
  for (Feature& feature : found) {
    feature.id = next_id_++;
    feature.generation = generation;
    feature.reference = placement.reference_of(feature.position);
    feature.reference_variance = variance;
    feature.unwarp = unwarp;
    features_.push_back(std::move(feature));
  }
}

void FeatureSet::start(const Flow& flow, const ImageRect& area, int count, std::span<const ImageRect> keep_out,
                       const Placement& placement) {
  features_.clear();
  still_places_.clear();
  FeatureSearch search{.area = area, .count = count, .taken = {}, .keep_out = keep_out};
  add(find_features(flow, search), placement, 0, 0);
  wanted_ = static_cast<std::uint32_t>(features_.size());
  renewal_due_ = renewal_wait_ = kRenewalWait;
}

void FeatureSet::collect(std::vector<FlowPoint>& points, const RegionMotion& step, const Eigen::Vector2d& centre) const {
  for (const Feature& feature : features_) {
    if (!feature.active) continue;
    const Eigen::Vector2d guess = feature.position + step.at(feature.reference - centre);
    points.push_back({point2f(feature.position), point2f(guess), {}, false});
  }
}

void FeatureSet::carry_over(std::span<const FlowPoint> points) {
  std::size_t i = 0;
  for (Feature& feature : features_) {
    feature.followed = false;
    if (!feature.active) continue;
    feature.previous = feature.position;
    const FlowPoint& point = points[i++];
    feature.followed = point.followed;
    if (point.followed) feature.position = eigen(point.to);
  }
}

void FeatureSet::match_active(const Flow& flow, const Placement& placement, const RegionMotion* step) {
  const Eigen::Matrix2d warp = placement.warp();
  for (Feature& feature : features_) {
    feature.matched = false;
    if (!feature.active) continue;
    if (!feature.followed) {
      feature.position = step != nullptr ? feature.previous + step->at(feature.reference - placement.centre)
                                         : placement.expected(feature.reference);
    }
    const PatchMatch match = feature.patch.align(flow.current(), feature.position, warp * feature.unwarp,
                                                 feature.followed ? kMostShiftFollowed : kMostShiftExpected);
    feature.matched = match.found && match.correlation >= options_.least_correlation;
    if (feature.matched) feature.position = match.position;
  }
}

void FeatureSet::match_inactive(const Flow& flow, const Placement& placement, std::uint32_t frame) {
  const Eigen::Matrix2d warp = placement.warp();
  for (Feature& feature : features_) {
    if (feature.active || (feature.id + frame) % 4 != 0) continue;
    feature.position = feature.previous = placement.expected(feature.reference);
    const PatchMatch match = feature.patch.align(flow.current(), feature.position, warp * feature.unwarp, kMostShiftExpected);
    feature.matched = match.found && match.correlation >= options_.least_correlation;
    if (feature.matched) feature.position = match.position;
  }
}

void FeatureSet::match_all_afresh(const Flow& flow, const Placement& placement) {
  const Eigen::Matrix2d warp = placement.warp();
  for (Feature& feature : features_) {
    feature.matched = feature.followed = feature.active = false;
    Eigen::Vector2d at = placement.expected(feature.reference);
    feature.position = feature.previous = at;
    if (feature.coarse) {
      const PatchMatch coarse =
          feature.coarse->align(flow.current(kCoarseLevel), feature.coarse_centre(at), warp * feature.unwarp, kMostShiftCoarse);
      if (!coarse.found || coarse.correlation < options_.least_correlation) continue;
      at = feature.from_coarse_centre(coarse.position);
    }
    const PatchMatch match = feature.patch.align(flow.current(), at, warp * feature.unwarp, kMostShiftExpected);
    feature.matched = match.found && match.correlation >= options_.least_correlation;
    if (feature.matched) feature.position = feature.previous = match.position;
  }
}

void FeatureSet::hand_over(const Flow& flow, const Placement& placement, double variance) {
  const Eigen::Matrix2d warp = placement.warp();
  std::vector<Feature> successors;
  for (Feature& feature : features_) {
    if (!feature.active || feature.matched || feature.missed == 0) continue;
    if (!feature.followed || !feature.moves_along) continue;
    std::optional<Feature> successor = successor_of(feature, flow, warp, variance);
    if (!successor) continue;
    successor->id = next_id_++;
    if (feature.generation == 0) {
      feature.active = false;
      successors.push_back(std::move(*successor));
    } else {
      feature = std::move(*successor);
    }
  }
  std::ranges::move(successors, std::back_inserter(features_));
}

void FeatureSet::keep_or_drop(const Placement& placement, bool region_seen) {
  for (Feature& feature : features_) {
    if (feature.matched) {
      feature.active = true;
      feature.missed = 0;
      if (feature.agrees) {
        feature.disagreed = 0;
        count_up(feature.agreed);
      } else if (region_seen) {
        count_up(feature.disagreed);
      }
      continue;
    }
    feature.agrees = false;
    count_up(feature.missed);
    const Eigen::Vector2d place = placement.expected(feature.reference);
    if (!region_seen || (feature.position - place).norm() > kStrayed) feature.position = place;
    if (feature.missed >= kMissedUntilLost) feature.active = false;
  }
  // While the region is lost, all it was last known by is kept: that is what it will be found again by.
  if (!region_seen) return;
  std::erase_if(features_, [this](const Feature& feature) {
    if (feature.generation > 0 && !feature.active) return true;
    // What moves otherwise in the background is foliage: its motion is worth showing.
    if (kind_ == RegionKind::background) return false;
    return feature.disagreed >= (feature.generation > 0 ? kDisagreedUntilLost : kDisagreedUntilUseless);
  });
  drop_surplus();
}

int FeatureSet::drop_still() {
  int dropped = 0;
  for (const Feature& feature : features_) {
    if (feature.still < kStillUntilBackground) continue;
    if (still_places_.size() < kMostStillPlaces) still_places_.push_back(feature.reference);
    if (feature.generation == 0) ++dropped;
  }
  std::erase_if(features_, [](const Feature& feature) { return feature.still >= kStillUntilBackground; });
  return dropped;
}

void FeatureSet::forget_matches() {
  for (Feature& feature : features_) feature.matched = feature.agrees = false;
}

/// Points of the reference picture that came back make the newest of those that stood in for them superfluous.
void FeatureSet::drop_surplus() {
  int surplus = active_count() - wanted();
  for (std::size_t i = features_.size(); i-- > 0 && surplus > 0;) {
    if (features_[i].generation == 0) continue;
    features_.erase(features_.begin() + static_cast<std::ptrdiff_t>(i));
    --surplus;
  }
}

void FeatureSet::replenish(const Flow& flow, const ImageRect& area, std::span<const ImageRect> keep_out,
                           const Placement& placement, double variance, std::uint32_t frame) {
  const int active = active_count();
  if (frame < renewal_due_ || active >= kRenewBelow * wanted_) return;

  std::vector<Eigen::Vector2d> taken;
  for (const Feature& feature : features_) {
    if (feature.active) taken.push_back(feature.position);
  }
  for (const Eigen::Vector2d& place : still_places_) taken.push_back(place + placement.camera.at(place));
  FeatureSearch search{.area = area, .count = static_cast<int>(wanted_) - active, .taken = taken, .keep_out = keep_out};
  search.spread_px2 = area.width * area.height;
  search.spread_count = static_cast<int>(wanted_);
  const bool by_cell = kind_ == RegionKind::background;
  if (by_cell) {
    search.area = cell_of(area, renewal_cell_);
    renewal_cell_ = (renewal_cell_ + 1) % (kCellsAcross * kCellsDown);
    search.count = std::max(1, search.count / static_cast<int>(kCellsAcross));
  }
  std::vector<Feature> found = find_features(flow, search);
  // Where there is nothing to be found, looking again soon would only cost time.
  const bool worth_it = static_cast<int>(found.size()) * 10 >= search.count;
  renewal_wait_ = worth_it || by_cell ? kRenewalWait : std::min(2 * renewal_wait_, kRenewalWaitMost);
  renewal_due_ = frame + renewal_wait_;
  add(std::move(found), placement, 1, variance);
}

void FeatureSet::limit(int count) {
  wanted_ = std::min(wanted_, static_cast<std::uint32_t>(count));
  if (features_.size() <= wanted_) return;
  const auto usefulness = [](const Feature& feature) {
    return (feature.active ? 4 : 0) + (feature.agrees ? 2 : 0) + (feature.generation == 0 ? 1 : 0);
  };
  std::ranges::stable_sort(features_, std::greater<>(), usefulness);
  features_.resize(wanted_);
}

void FeatureSet::drop_inside(const ImageRect& area) {
  std::erase_if(features_, [&](const Feature& feature) { return contains(area, feature.position); });
}

void FeatureSet::save(CheckpointWriter& out) const {
  out.put(static_cast<std::uint32_t>(features_.size()));
  for (const Feature& feature : features_) feature.save(out);
  out.put(static_cast<std::uint32_t>(still_places_.size()));
  for (const Eigen::Vector2d& place : still_places_) out.put(place);
  for (const std::uint32_t value : {wanted_, next_id_, renewal_due_, renewal_wait_, renewal_cell_}) out.put(value);
}

void FeatureSet::load(CheckpointReader& in) {
  features_.clear();
  still_places_.clear();
  const std::size_t count = in.get_count(sizeof(Patch::Pixels));
  for (std::size_t i = 0; i < count && in.ok(); ++i) features_.push_back(Feature::load(in));
  const std::size_t places = in.get_count(sizeof(Eigen::Vector2d));
  for (std::size_t i = 0; i < places; ++i) in.get(still_places_.emplace_back(0, 0));
  for (std::uint32_t* value : {&wanted_, &next_id_, &renewal_due_, &renewal_wait_, &renewal_cell_}) in.get(*value);
}

}  // namespace roseau::tracking
