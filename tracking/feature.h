// Feature: one point of a region, recognised by its patch; and the finding of new ones.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry.h"
#include "tracking/checkpoint.h"
#include "tracking/flow.h"
#include "tracking/patch.h"

namespace roseau::tracking {

/// The pyramid level of the coarse patches, by which a lost region is looked for far away.
inline constexpr int kCoarseLevel = 2;

struct Feature {
  std::uint32_t id = 0;  // unique within a region, in order of creation
  /// 0: cut from the region's reference picture. Later ones replace points that were lost for good; where they would have
  /// been in the reference picture was worked out from the region's motion, with that motion's error.
  std::uint16_t generation = 0;
  Eigen::Vector2i cut_at{0, 0};  // px, in the picture that the patch was cut from
  Patch patch;
  std::optional<Patch> coarse;  // around the same place at kCoarseLevel

  /// How the picture was turned and stretched against the reference when the patch was cut, inverted.
  Eigen::Matrix2d unwarp = Eigen::Matrix2d::Identity();

  Eigen::Vector2d reference{0, 0};  // px, in the reference picture, the camera's motion taken out
  double reference_variance = 0;    // of either coordinate of `reference`, px^2: 0 for generation 0
  Eigen::Vector2d position{0, 0};   // px, in the current picture
  Eigen::Vector2d previous{0, 0};   // px, in the previous picture

  bool active = true;           // followed from frame to frame; otherwise only looked for where it should be
  bool followed = false;        // by flow, from the previous picture
  bool matched = true;          // its patch was recognised in this picture
  bool agrees = true;           // and is where its region's motion puts it
  bool moves_along = true;      // flow took it the way its region went, matched or not
  std::uint16_t missed = 0;     // frames in a row without a match
  std::uint16_t disagreed = 0;  // frames in a row of moving otherwise
  std::uint16_t agreed = 0;     // frames in all of moving with the region
  std::uint16_t still = 0;      // frames of standing still while the region moved

  // How restless it is: mean of its squared steps from frame to frame, px^2, over the last so many frames.
  double unrest_px2 = 0;
  std::uint16_t watched = 0;

  /// Where the coarse patch's centre is, at kCoarseLevel, when the feature itself is at `at`.
  Eigen::Vector2d coarse_centre(const Eigen::Vector2d& at) const;
  Eigen::Vector2d from_coarse_centre(const Eigen::Vector2d& centre) const;

  void save(CheckpointWriter& out) const;
  /// Fails the reader where the bytes cannot be a feature.
  static Feature load(CheckpointReader& in);
};

struct FeatureSearch {
  ImageRect area;  // px with the origin at the CENTRE of the upper left pixel, as positions are
  int count = 0;
  std::span<const Eigen::Vector2d> taken;  // keep the usual distance from these
  std::span<const ImageRect> keep_out;     // and out of these
  /// Where the count could be spread: sets the least distance between points. 0: over the area itself.
  double spread_px2 = 0;
  int spread_count = 0;
};

/// A point of the next generation in the place of one whose look has changed but which still moves along: cut from the
/// current picture, its reference taken over from `worn`. Nothing where the picture gives no patch there.
std::optional<Feature> successor_of(const Feature& worn, const Flow& flow, const Eigen::Matrix2d& warp, double variance);

/// The strongest corners (Shi and Tomasi) of the current picture, spread over the area; strongest first. Generation, id and
/// reference position are left to the caller.
std::vector<Feature> find_features(const Flow& flow, const FeatureSearch& search);

}  // namespace roseau::tracking
