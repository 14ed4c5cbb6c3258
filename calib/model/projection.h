// From points to pixels and back, through mrcal.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "calib/model/camera_model.h"

namespace roseau::calib {

/// How an image point moves with the point it shows and with the lens: row-major, row 0 of x, row 1 of y.
struct ProjectionGradient {
  std::array<double, 6> by_point{};                                     // 2 x 3, px per metre of point_in_camera
  std::array<double, 2 * CameraModel::kMaxIntrinsics> by_intrinsics{};  // 2 x intrinsics_count(lens), packed
};

/// A camera model prepared for use. Cheap to copy; all functions may be called by several threads at once.
class Projection {
 public:
  /// The model must pass check().
  explicit Projection(const CameraModel& camera);

  const CameraModel& camera() const { return camera_; }

  /// In front of the camera by at least `min_depth_m`, and near enough to the axis for the lens formula to hold: a strong
  /// distortion polynomial folds back what lies far outside the picture.
  bool sees(const Vec3& point_in_camera, double min_depth_m = 1e-3) const;

  /// Image point of a point that the camera sees().
  Vec2 project(const Vec3& point_in_world) const;
  Vec2 project_in_camera(const Vec3& point_in_camera, ProjectionGradient* gradient = nullptr) const;

  /// Many at once: `image_points` has the size of `points_in_camera`. About 7 ns a point.
  void project_in_camera(std::span<const Vec3> points_in_camera, std::span<Vec2> image_points) const;

  /// Unit vector, in the camera's frame, of the ray seen at an image point; empty where no ray leads there.
  std::optional<Vec3> unproject(const Vec2& image_point) const;
  /// The same in the world's axes.
  std::optional<Vec3> ray_in_world(const Vec2& image_point) const;

  /// Tangent of the largest angle from the axis at which the distortion still grows outwards.
  double largest_tangent() const { return largest_tangent_; }

 private:
  CameraModel camera_;
  double largest_tangent_ = 0;
};

}  // namespace roseau::calib
