#include "synthesis/scene.h"

#include <algorithm>
#include <utility>

namespace roseau::synthesis {

std::vector<double> BallsScene::four_places() { return {-1.3, -0.6, 2.9, 1.3, -0.5, 3.4, -0.5, -0.9, 4.2, 0.8, -0.8, 2.4}; }

std::vector<CameraScene> Scene::two_cameras() {
  CameraScene left;
  CameraScene right;
  right.position_in_world_m.x = 1.5;
  return {left, right};
}

Scene large_camera_scene() {
  Scene scene;
  for (CameraScene& camera : scene.cameras) {
    camera.width_px = 1280;
    camera.height_px = 1024;
    camera.format = PixelFormat::mono8;
    camera.focal_length_px = 2000;
  }
  return scene;
}

calib::CameraModel model_of(const CameraScene& camera) {
  calib::CameraModel model = calib::look_at(camera.width_px, camera.height_px, camera.focal_length_px,
                                            camera.position_in_world_m, camera.look_at_in_world_m);
  constexpr std::pair<std::string_view, calib::Lens> kLenses[] = {{"pinhole", calib::Lens::pinhole},
                                                                  {"opencv4", calib::Lens::opencv4},
                                                                  {"opencv5", calib::Lens::opencv5},
                                                                  {"opencv8", calib::Lens::opencv8}};
  model.lens = std::ranges::find(kLenses, camera.lens, &std::pair<std::string_view, calib::Lens>::first)->second;
  constexpr std::ptrdiff_t kFirstDistortion = 4;
  std::ranges::copy(camera.distortion, model.intrinsics.begin() + kFirstDistortion);
  return model;
}

}  // namespace roseau::synthesis
