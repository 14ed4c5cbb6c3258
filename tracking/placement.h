// Where things of the reference picture are in the current one.
//
// The reference picture is the one a region was first seen in, with the camera's motion up to then taken out: it is common
// to all regions of a camera. Coordinates are px with the origin at the CENTRE of the upper left pixel.
#pragma once

#include <Eigen/Core>

namespace roseau::tracking {

/// Affine motion about a centre: what was at `centre + r` is displaced by `displacement + gradient * r`.
struct RegionMotion {
  Eigen::Vector2d displacement = Eigen::Vector2d::Zero();  // of the centre, px
  Eigen::Matrix2d gradient = Eigen::Matrix2d::Zero();      // px per px: turning and stretching

  Eigen::Vector2d at(const Eigen::Vector2d& offset) const { return displacement + gradient * offset; }
};

/// How the picture of things that stand still has moved, because the camera did.
struct CameraMotion {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  RegionMotion motion;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of motion.displacement, px^2

  Eigen::Vector2d at(const Eigen::Vector2d& reference) const { return motion.at(reference - centre); }
};

/// A region's own motion on top of the camera's.
struct Placement {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  RegionMotion motion;
  CameraMotion camera;

  Eigen::Vector2d expected(const Eigen::Vector2d& reference) const;
  /// The inverse of expected().
  Eigen::Vector2d reference_of(const Eigen::Vector2d& position) const;
  /// What turns and stretches offsets in the reference picture into offsets in this one.
  Eigen::Matrix2d warp() const;
};

}  // namespace roseau::tracking
