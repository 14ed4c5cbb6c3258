#include "synthesis/scene.h"

#include <algorithm>
#include <limits>

#include "synthesis/camera/objects.h"
#include "synthesis/camera/pinhole.h"

namespace roseau::synthesis {

std::vector<CameraScene> Scene::two_cameras() {
  CameraScene left;
  CameraScene right;
  right.position_in_world_m.x = 0.3;
  return {left, right};
}

Scene large_camera_scene() {
  Scene scene;
  for (CameraScene& camera : scene.cameras) {
    camera.width_px = 1280;
    camera.height_px = 1024;
    camera.format = PixelFormat::mono8;
    camera.focal_length_px = 1600;
  }
  return scene;
}

CameraCalibration calibration_of(const CameraScene& camera) {
  return look_at(camera.width_px, camera.height_px, camera.focal_length_px, camera.position_in_world_m,
                 camera.look_at_in_world_m);
}

Vec3 target_centre_in_world(const Scene& scene) {
  const PlaneWindow window = branch_target_window(scene.branch.root_in_world_m, scene.branch.length_m);
  return {(window.left_m + window.right_m) / 2, scene.branch.root_in_world_m.y, (window.bottom_m + window.top_m) / 2};
}

ImageRect target_region(const Scene& scene, const CameraScene& camera, double deflection_m) {
  const CameraCalibration calibration = calibration_of(camera);
  const PlaneWindow window = branch_target_window(scene.branch.root_in_world_m, scene.branch.length_m);
  Vec2 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Vec2 high{-low.x, -low.y};
  for (const double x : {window.left_m, window.right_m}) {
    for (const double z : {window.bottom_m, window.top_m}) {
      const Vec2 corner = project(calibration, {x + deflection_m, scene.branch.root_in_world_m.y, z});
      low = {std::min(low.x, corner.x), std::min(low.y, corner.y)};
      high = {std::max(high.x, corner.x), std::max(high.y, corner.y)};
    }
  }
  return {low.x + 0.5, low.y + 0.5, high.x - low.x, high.y - low.y};  // from pixel centres to the ImageRect's corners
}

Vec2 target_displacement_px(const Scene& scene, const CameraScene& camera, double deflection_m) {
  const CameraCalibration calibration = calibration_of(camera);
  const Vec3 centre = target_centre_in_world(scene);
  const Vec2 rest = project(calibration, centre);
  const Vec2 now = project(calibration, {centre.x + deflection_m, centre.y, centre.z});
  return {now.x - rest.x, now.y - rest.y};
}

}  // namespace roseau::synthesis
