// Backdrop: the landscape as one camera sees it. What stands still is painted once; clouds drift, hedge and grass sway.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "calib/model/projection.h"
#include "synthesis/render/picture.h"
#include "synthesis/render/visible_scene.h"

namespace roseau::render {

class Backdrop {
 public:
  Backdrop(const VisibleScene& scene, const calib::Projection& projection, const InkMaker& ink);

  /// Fills the picture with the backdrop at a time.
  void paint(double time_s, double sway, Picture& picture);

 private:
  struct SkyPixel {
    std::uint32_t pixel = 0;
    float share = 0;  // of the pixel that is sky
    Landscape::CloudCell cloud;
    Ink clear{};
  };
  // Pixels of a row that sway: how far while the top of the hedge moves by its amplitude.
  struct SwayingRow {
    int y = 0;
    std::vector<float> reach_px;  // per pixel of the row
  };

  void paint_landscape(const calib::Projection& projection, const InkMaker& ink);
  void paint_pixel(int x, int y, const Vec3& ray, const calib::CameraModel& camera, const InkMaker& ink, SwayingRow& row);
  void drift_clouds(double time_s);
  void drift_group(std::size_t group, double drift_m);
  void sway(double time_s, double sway, Picture& picture);

  const VisibleScene& scene_;
  Picture still_;  // everything but the sky; black where there is sky
  Picture now_;    // with the clouds of late
  std::vector<SkyPixel> sky_;
  std::vector<SwayingRow> swaying_;
  std::vector<float> wave_;  // per column, -1..1
  Ink cloud_{};
  // The clouds of each group of sky pixels are redrawn at times of their own, so that no frame has to redraw all.
  static constexpr std::size_t kCloudGroups = 8;
  std::array<std::int64_t, kCloudGroups> cloud_steps_;
};

}  // namespace roseau::render
