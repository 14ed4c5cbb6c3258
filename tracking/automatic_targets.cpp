#include "tracking/automatic_targets.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tracking/patch.h"

namespace roseau::tracking {

namespace {

constexpr float kLeastMatched = 0.7F;      // of the frames, for a point to be judged
constexpr float kNeighbourDistance = 60;   // px
constexpr float kLeastCorrelation = 0.7F;  // of two points' motions, to belong together
constexpr std::size_t kLeastPoints = 6;
constexpr double kMostOverlap = 0.3;  // of the smaller region

struct Mover {
  Eigen::Vector2f position;
  std::vector<Eigen::Vector2f> motion;  // about its mean, scaled to unit energy
  double rms_px = 0;
};

/// Groups of indices, by union of linked pairs.
class Groups {
 public:
  explicit Groups(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void link(std::size_t a, std::size_t b) {
    const std::size_t first = std::min(root(a), root(b));
    const std::size_t second = std::max(root(a), root(b));
    parent_[second] = first;
  }

 private:
  std::vector<std::size_t> parent_;
};

struct Candidate {
  ImageRect region;
  double weight = 0;
};

Candidate region_of(const std::vector<const Mover*>& members) {
  Eigen::Vector2f low = members.front()->position;
  Eigen::Vector2f high = low;
  double weight = 0;
  for (const Mover* member : members) {
    low = low.cwiseMin(member->position);
    high = high.cwiseMax(member->position);
    weight += member->rms_px;
  }
  constexpr float kMargin = Patch::kSide;
  return {{low.x() - kMargin, low.y() - kMargin, high.x() - low.x() + 2 * kMargin, high.y() - low.y() + 2 * kMargin}, weight};
}

double overlap(const ImageRect& a, const ImageRect& b) {
  const double width = std::min(a.x + a.width, b.x + b.width) - std::max(a.x, b.x);
  const double height = std::min(a.y + a.height, b.y + b.height) - std::max(a.y, b.y);
  if (width <= 0 || height <= 0) return 0;
  return width * height / std::min(a.width * a.height, b.width * b.height);
}

bool move_together(const Mover& a, const Mover& b) {
  if ((a.position - b.position).norm() > kNeighbourDistance) return false;
  float correlation = 0;
  for (std::size_t i = 0; i < a.motion.size(); ++i) correlation += a.motion[i].dot(b.motion[i]);
  return correlation >= kLeastCorrelation;
}

}  // namespace

void AutomaticTargets::observe(std::span<const Feature> features, const CameraMotion& camera) {
  ++frames_;
  for (const Feature& feature : features) {
    if (!feature.active) continue;
    Track& track = tracks_[feature.id];
    const Eigen::Vector2d moved = feature.position - feature.reference - camera.at(feature.reference);
    // A gap, and the time before a point was there, is filled with what was seen next.
    track.displacement.resize(frames_, moved.cast<float>());
    track.position = feature.position.cast<float>();
    if (feature.matched) ++track.matched;
  }
}

std::vector<ImageRect> AutomaticTargets::choose() {
  std::vector<Mover> movers;
  for (auto& [id, track] : tracks_) {
    if (track.displacement.size() != frames_) continue;
    if (static_cast<float>(track.matched) < kLeastMatched * static_cast<float>(frames_)) continue;
    Eigen::Vector2f mean = Eigen::Vector2f::Zero();
    for (const Eigen::Vector2f& at : track.displacement) mean += at / static_cast<float>(frames_);
    double energy = 0;
    for (Eigen::Vector2f& at : track.displacement) {
      at -= mean;
      energy += static_cast<double>(at.squaredNorm());
    }
    const double rms_px = std::sqrt(energy / frames_);
    if (rms_px < options_.automatic_least_motion_px) continue;
    for (Eigen::Vector2f& at : track.displacement) at /= static_cast<float>(std::sqrt(energy));
    movers.push_back({track.position, std::move(track.displacement), rms_px});
  }
  tracks_.clear();
  frames_ = 0;

  Groups groups(movers.size());
  for (std::size_t a = 0; a < movers.size(); ++a) {
    for (std::size_t b = a + 1; b < movers.size(); ++b) {
      if (move_together(movers[a], movers[b])) groups.link(a, b);
    }
  }
  std::map<std::size_t, std::vector<const Mover*>> members;
  for (std::size_t i = 0; i < movers.size(); ++i) members[groups.root(i)].push_back(&movers[i]);
  std::vector<Candidate> candidates;
  for (const auto& [root, group] : members) {
    if (group.size() >= kLeastPoints) candidates.push_back(region_of(group));
  }
  std::ranges::stable_sort(candidates, std::greater<>(), &Candidate::weight);

  std::vector<ImageRect> chosen;
  for (const Candidate& candidate : candidates) {
    if (chosen.size() >= static_cast<std::size_t>(options_.automatic_most_targets)) break;
    const auto clashes = [&](const ImageRect& other) { return overlap(candidate.region, other) > kMostOverlap; };
    if (std::ranges::none_of(chosen, clashes)) chosen.push_back(candidate.region);
  }
  return chosen;
}

void AutomaticTargets::save(CheckpointWriter& out) const {
  out.put(frames_);
  out.put(static_cast<std::uint32_t>(tracks_.size()));
  for (const auto& [id, track] : tracks_) {
    out.put(id);
    out.put(track.matched);
    out.put(track.position);
    out.put(static_cast<std::uint32_t>(track.displacement.size()));
    for (const Eigen::Vector2f& at : track.displacement) out.put(at);
  }
}

void AutomaticTargets::load(CheckpointReader& in) {
  tracks_.clear();
  in.get(frames_);
  const std::size_t count = in.get_count(4 * sizeof(std::uint32_t));
  for (std::size_t i = 0; i < count && in.ok(); ++i) {
    std::uint32_t id = 0;
    in.get(id);
    Track& track = tracks_[id];
    in.get(track.matched);
    in.get(track.position);
    track.displacement.resize(in.get_count(sizeof(Eigen::Vector2f)));
    for (Eigen::Vector2f& at : track.displacement) in.get(at);
  }
}

}  // namespace roseau::tracking
