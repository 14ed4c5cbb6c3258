#include "synthesis/camera/pinhole.h"

#include <cmath>

#include "core/check.h"

namespace roseau::synthesis {

namespace {
Vec3 minus(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

Vec3 unit(const Vec3& a) {
  const double length = std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z);
  ROSEAU_CHECK(length > 0);
  return {a.x / length, a.y / length, a.z / length};
}

Vec3 cross(const Vec3& a, const Vec3& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

Vec3 to_camera(const CameraCalibration& camera, const Vec3& point_in_world) {
  const Vec3 p = minus(point_in_world, camera.position_in_world_m);
  const auto& r = camera.rotation_camera_from_world;
  return {r[0] * p.x + r[1] * p.y + r[2] * p.z, r[3] * p.x + r[4] * p.y + r[5] * p.z, r[6] * p.x + r[7] * p.y + r[8] * p.z};
}
}  // namespace

CameraCalibration look_at(std::uint32_t width, std::uint32_t height, double focal_length_px, const Vec3& position_in_world,
                          const Vec3& target_in_world) {
  const Vec3 forward = unit(minus(target_in_world, position_in_world));
  const Vec3 right = unit(cross(forward, {0, 0, 1}));
  const Vec3 down = cross(forward, right);
  CameraCalibration camera;
  camera.width = width;
  camera.height = height;
  camera.fx_px = camera.fy_px = focal_length_px;
  camera.cx_px = (width - 1) / 2.0;
  camera.cy_px = (height - 1) / 2.0;
  camera.rotation_camera_from_world = {right.x, right.y, right.z, down.x, down.y, down.z, forward.x, forward.y, forward.z};
  camera.position_in_world_m = position_in_world;
  return camera;
}

Vec2 project(const CameraCalibration& camera, const Vec3& point_in_world) {
  const Vec3 p = to_camera(camera, point_in_world);
  return {camera.fx_px * p.x / p.z + camera.cx_px, camera.fy_px * p.y / p.z + camera.cy_px};
}

double depth_m(const CameraCalibration& camera, const Vec3& point_in_world) { return to_camera(camera, point_in_world).z; }

Vec3 ray_in_world(const CameraCalibration& camera, const Vec2& image_point) {
  const double x = (image_point.x - camera.cx_px) / camera.fx_px;
  const double y = (image_point.y - camera.cy_px) / camera.fy_px;
  const auto& r = camera.rotation_camera_from_world;
  return {r[0] * x + r[3] * y + r[6], r[1] * x + r[4] * y + r[7], r[2] * x + r[5] * y + r[8]};
}

Vec3 on_plane(const CameraCalibration& camera, const Vec2& image_point, double plane_y_m) {
  const Vec3 ray = ray_in_world(camera, image_point);
  const Vec3& from = camera.position_in_world_m;
  const double reach = (plane_y_m - from.y) / ray.y;
  return {from.x + reach * ray.x, plane_y_m, from.z + reach * ray.z};
}

}  // namespace roseau::synthesis
