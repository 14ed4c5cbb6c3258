#include "tracking/feature.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace roseau::tracking {

namespace {

constexpr double kScale = 1 << kCoarseLevel;
constexpr double kLeastQuality = 0.01;  // of the best corner's
constexpr int kCornerBlock = 7;         // px
// Points nearer than half a patch look at mostly the same pixels.
constexpr double kLeastDistance = Patch::kSide / 2.0;
constexpr double kMostDistance = 60;  // px
constexpr double kFurthest = 1e6;     // px: no place in or near a picture is further

Eigen::Vector2i coarse_pixel(const Eigen::Vector2i& cut_at) {
  return (cut_at.cast<double>() / kScale).array().round().cast<int>();
}

double distance_between(const FeatureSearch& search, const cv::Rect& area) {
  const double px2 = search.spread_px2 > 0 ? search.spread_px2 : area.area();
  const int count = search.spread_count > 0 ? search.spread_count : search.count;
  return std::clamp(0.7 * std::sqrt(px2 / count), kLeastDistance, kMostDistance);
}

/// Only corners whose patch lies inside the picture.
cv::Rect usable(const ImageRect& area, const cv::Mat& gray) {
  constexpr int kMargin = Patch::kReach + 2;
  const cv::Rect inner(kMargin, kMargin, gray.cols - 2 * kMargin, gray.rows - 2 * kMargin);
  const cv::Rect wanted(
      cv::Point(static_cast<int>(std::ceil(area.x)), static_cast<int>(std::ceil(area.y))),
      cv::Point(static_cast<int>(std::floor(area.x + area.width)) + 1, static_cast<int>(std::floor(area.y + area.height)) + 1));
  if (inner.width <= 0 || inner.height <= 0) return {};
  return wanted & inner;
}

cv::Mat free_places(const FeatureSearch& search, const cv::Rect& area, double distance) {
  cv::Mat mask(area.size(), CV_8U, cv::Scalar(255));
  for (const Eigen::Vector2d& taken : search.taken) {
    const cv::Point at(static_cast<int>(std::lround(taken.x())) - area.x, static_cast<int>(std::lround(taken.y())) - area.y);
    cv::circle(mask, at, static_cast<int>(std::lround(distance)), cv::Scalar(0), cv::FILLED);
  }
  for (const ImageRect& out : search.keep_out) {
    const cv::Rect rect(static_cast<int>(std::floor(out.x)) - area.x, static_cast<int>(std::floor(out.y)) - area.y,
                        static_cast<int>(std::ceil(out.width)) + 1, static_cast<int>(std::ceil(out.height)) + 1);
    cv::rectangle(mask, rect, cv::Scalar(0), cv::FILLED);
  }
  return mask;
}

}  // namespace

Eigen::Vector2d Feature::coarse_centre(const Eigen::Vector2d& at) const {
  const Eigen::Vector2d rounding = cut_at.cast<double>() - kScale * coarse_pixel(cut_at).cast<double>();
  return (at - rounding) / kScale;
}

Eigen::Vector2d Feature::from_coarse_centre(const Eigen::Vector2d& centre) const {
  const Eigen::Vector2d rounding = cut_at.cast<double>() - kScale * coarse_pixel(cut_at).cast<double>();
  return kScale * centre + rounding;
}

void Feature::save(CheckpointWriter& out) const {
  out.put_bytes(std::as_bytes(std::span(patch.pixels())));
  out.put(coarse.has_value());
  if (coarse) out.put_bytes(std::as_bytes(std::span(coarse->pixels())));
  out.put(id);
  out.put(generation);
  out.put(cut_at);
  out.put(unwarp);
  out.put(reference_variance);
  for (const Eigen::Vector2d* place : {&reference, &position, &previous}) out.put(*place);
  for (const bool flag : {active, followed, matched, agrees, moves_along}) out.put(flag);
  for (const std::uint16_t counter : {missed, disagreed, agreed, still, watched}) out.put(counter);
  out.put(unrest_px2);
}

Feature Feature::load(CheckpointReader& in) {
  const auto load_patch = [&in](Patch& loaded) {
    Patch::Pixels pixels{};
    const auto bytes = in.take(pixels.size());
    if (!bytes.empty()) std::memcpy(pixels.data(), bytes.data(), bytes.size());
    if (const auto made = Patch::from_pixels(pixels)) {
      loaded = *made;
    } else {
      in.fail();
    }
  };
  Feature feature;
  load_patch(feature.patch);
  bool has_coarse = false;
  in.get(has_coarse);
  if (has_coarse) load_patch(feature.coarse.emplace());
  in.get(feature.id);
  in.get(feature.generation);
  in.get(feature.cut_at);
  in.get(feature.unwarp);
  in.get(feature.reference_variance);
  for (Eigen::Vector2d* place : {&feature.reference, &feature.position, &feature.previous}) {
    in.get(*place);
    if (!(place->cwiseAbs().maxCoeff() < kFurthest)) in.fail();  // NaN fails too
  }
  for (bool* flag : {&feature.active, &feature.followed, &feature.matched, &feature.agrees, &feature.moves_along})
    in.get(*flag);
  for (std::uint16_t* counter : {&feature.missed, &feature.disagreed, &feature.agreed, &feature.still, &feature.watched})
    in.get(*counter);
  in.get(feature.unrest_px2);
  if (!(feature.unrest_px2 >= 0)) in.fail();  // NaN fails too
  return feature;
}

std::optional<Feature> successor_of(const Feature& worn, const Flow& flow, const Eigen::Matrix2d& warp, double variance) {
  if (!(worn.position.cwiseAbs().maxCoeff() < kFurthest)) return std::nullopt;
  const Eigen::Vector2i at = worn.position.array().round().matrix().cast<int>();
  const std::optional<Patch> patch = Patch::cut(flow.current(), at.x(), at.y());
  if (!patch) return std::nullopt;
  Feature feature;
  feature.generation = static_cast<std::uint16_t>(std::min(worn.generation + 1, 1000));
  feature.cut_at = at;
  feature.patch = *patch;
  feature.unwarp = warp.inverse();
  feature.reference = worn.reference + feature.unwarp * (at.cast<double>() - worn.position);
  feature.reference_variance = worn.reference_variance + variance;
  feature.position = at.cast<double>();
  feature.previous = worn.previous + (feature.position - worn.position);
  feature.followed = true;
  feature.agreed = worn.agreed;
  return feature;
}

std::vector<Feature> find_features(const Flow& flow, const FeatureSearch& search) {
  const cv::Mat& gray = flow.current();
  const cv::Rect area = usable(search.area, gray);
  std::vector<Feature> features;
  if (area.empty() || search.count <= 0) return features;

  const double distance = distance_between(search, area);
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(gray(area), corners, search.count, kLeastQuality, distance, free_places(search, area, distance),
                          kCornerBlock);
  for (const cv::Point2f& corner : corners) {
    const int x = static_cast<int>(std::lround(corner.x)) + area.x;
    const int y = static_cast<int>(std::lround(corner.y)) + area.y;
    std::optional<Patch> patch = Patch::cut(gray, x, y);
    if (!patch) continue;
    Feature feature;
    feature.cut_at = {x, y};
    feature.patch = *patch;
    const Eigen::Vector2i coarse = coarse_pixel(feature.cut_at);
    if (flow.levels() >= kCoarseLevel) feature.coarse = Patch::cut(flow.current(kCoarseLevel), coarse.x(), coarse.y());
    feature.position = feature.previous = feature.reference = {x, y};
    features.push_back(std::move(feature));
  }
  return features;
}

}  // namespace roseau::tracking
