#include "calib/model/projection.h"

// mrcal's headers are plain C without a guard of their own.
extern "C" {
#include <mrcal/mrcal.h>
}

#include <cmath>

#include "core/check.h"

namespace roseau::calib {

namespace {

// mrcal's points and ours have the same shape, so that arrays pass without a copy.
static_assert(sizeof(mrcal_point3_t) == sizeof(Vec3) && offsetof(Vec3, z) == 2 * sizeof(double));
static_assert(sizeof(mrcal_point2_t) == sizeof(Vec2));

mrcal_lensmodel_t mrcal_lens(Lens lens) {
  mrcal_lensmodel_t model{};
  switch (lens) {
    case Lens::pinhole:
      model.type = MRCAL_LENSMODEL_PINHOLE;
      break;
    case Lens::opencv4:
      model.type = MRCAL_LENSMODEL_OPENCV4;
      break;
    case Lens::opencv5:
      model.type = MRCAL_LENSMODEL_OPENCV5;
      break;
    case Lens::opencv8:
      model.type = MRCAL_LENSMODEL_OPENCV8;
      break;
  }
  return model;
}

// Radius in the picture (focal lengths from the centre) of a ray at tangent r, tangential terms left out.
double distorted_radius(std::span<const double> intrinsics, double r) {
  const auto k = [intrinsics](std::size_t i) { return i < intrinsics.size() ? intrinsics[i] : 0.0; };
  const double r2 = r * r;
  const double over = 1 + r2 * (k(4) + r2 * (k(5) + r2 * k(8)));
  const double under = 1 + r2 * (k(9) + r2 * (k(10) + r2 * k(11)));
  return r * over / under;
}

constexpr double kWidestTangent = 20;  // 87 degrees from the axis: beyond what these models are made for
constexpr double kTangentStep = 1.0 / 256;

double find_largest_tangent(std::span<const double> intrinsics) {
  double radius = 0;
  for (double r = kTangentStep; r < kWidestTangent; r += kTangentStep) {
    const double next = distorted_radius(intrinsics, r);
    if (!(next > radius)) return r - kTangentStep;
    radius = next;
  }
  return kWidestTangent;
}

}  // namespace

Projection::Projection(const CameraModel& camera)
    : camera_(camera), largest_tangent_(find_largest_tangent(camera.used_intrinsics())) {
  ROSEAU_CHECK(check(camera).has_value());
}

bool Projection::sees(const Vec3& point_in_camera, double min_depth_m) const {
  const Vec3& p = point_in_camera;
  const double limit = largest_tangent_ * p.z;
  return p.z >= min_depth_m && p.x * p.x + p.y * p.y <= limit * limit;
}

Vec2 Projection::project(const Vec3& point_in_world) const { return project_in_camera(to_camera(camera_, point_in_world)); }

Vec2 Projection::project_in_camera(const Vec3& point_in_camera, ProjectionGradient* gradient) const {
  const mrcal_lensmodel_t lens = mrcal_lens(camera_.lens);
  const mrcal_point3_t point{.xyz = {point_in_camera.x, point_in_camera.y, point_in_camera.z}};
  mrcal_point2_t image{};
  std::array<mrcal_point3_t, 2> by_point{};
  const bool done = mrcal_project(&image, gradient == nullptr ? nullptr : by_point.data(),
                                  gradient == nullptr ? nullptr : gradient->by_intrinsics.data(), &point, 1, &lens,
                                  camera_.intrinsics.data());
  ROSEAU_CHECK(done);
  if (gradient != nullptr) {
    for (std::size_t row = 0; row < 2; ++row) {
      for (std::size_t column = 0; column < 3; ++column) gradient->by_point.at(3 * row + column) = by_point.at(row).xyz[column];
    }
  }
  return {image.x, image.y};
}

void Projection::project_in_camera(std::span<const Vec3> points_in_camera, std::span<Vec2> image_points) const {
  ROSEAU_CHECK(points_in_camera.size() == image_points.size());
  const mrcal_lensmodel_t lens = mrcal_lens(camera_.lens);
  const bool done = mrcal_project(reinterpret_cast<mrcal_point2_t*>(image_points.data()), nullptr, nullptr,
                                  reinterpret_cast<const mrcal_point3_t*>(points_in_camera.data()),
                                  static_cast<int>(points_in_camera.size()), &lens, camera_.intrinsics.data());
  ROSEAU_CHECK(done);
}

std::optional<Vec3> Projection::unproject(const Vec2& image_point) const {
  const mrcal_lensmodel_t lens = mrcal_lens(camera_.lens);
  const mrcal_point2_t image{.xy = {image_point.x, image_point.y}};
  mrcal_point3_t ray{};
  if (!mrcal_unproject(&ray, &image, 1, &lens, camera_.intrinsics.data())) return std::nullopt;
  const double length = std::sqrt(ray.x * ray.x + ray.y * ray.y + ray.z * ray.z);
  const Vec3 unit{ray.x / length, ray.y / length, ray.z / length};
  if (!std::isfinite(length) || !sees(unit, 1e-6)) return std::nullopt;
  // Where no ray leads, the search behind mrcal's function ends at the nearest it found.
  const Vec2 again = project_in_camera(unit);
  if (!(std::hypot(again.x - image_point.x, again.y - image_point.y) < 1e-3)) return std::nullopt;
  return unit;
}

std::optional<Vec3> Projection::ray_in_world(const Vec2& image_point) const {
  const std::optional<Vec3> ray = unproject(image_point);
  if (!ray) return std::nullopt;
  const auto& r = camera_.rotation_camera_from_world;
  return Vec3{r[0] * ray->x + r[3] * ray->y + r[6] * ray->z, r[1] * ray->x + r[4] * ray->y + r[7] * ray->z,
              r[2] * ray->x + r[5] * ray->y + r[8] * ray->z};
}

}  // namespace roseau::calib
