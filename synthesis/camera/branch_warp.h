// BranchWarp: puts the bent branch into a picture. Every pixel of the picture looks back through the pinhole to the branch's
// plane, undoes the bending there, and reads the branch's drawing: exact geometry, sub-pixel accurate.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/sample.h"
#include "synthesis/camera/canvas.h"

namespace roseau::synthesis {

class BranchWarp {
 public:
  /// `texture`: the branch at rest. `root_z_m`, `length_m`: between which heights it bends. `channels`: 3 (blue, green, red)
  /// or 1 (grey: the texture is converted). Deflections beyond +-`reach_m` are cut off at the edge of the prepared region.
  BranchWarp(const Layer& texture, const CameraCalibration& camera, double root_z_m, double length_m, double reach_m,
             int channels);

  /// Lays the branch over one row of the picture, as the mean of the pictures at the given deflections.
  /// `row` holds the whole row's bytes. One thread at a time.
  void draw_row(std::uint32_t y, std::span<const double> deflections_m, std::span<std::uint8_t> row);

  /// Rows outside [first_row, end_row) are left as they are.
  std::uint32_t first_row() const { return first_row_; }
  std::uint32_t end_row() const { return first_row_ + static_cast<std::uint32_t>(rows_.size()); }

 private:
  // Where a pixel looks in the texture while the branch is at rest, and how far that moves per metre of deflection.
  struct Look {
    float x_px = 0;
    float y_px = 0;
    float gain_px_per_m = 0;
  };
  struct Row {
    std::uint32_t first_x = 0;
    std::vector<Look> looks;
    float opaque_begin_px = 0;  // texture columns outside hold nothing in the texture rows that this row sees
    float opaque_end_px = 0;
  };

  void prepare_row(std::uint32_t y, const CameraCalibration& camera, double root_z_m, double length_m, double reach_m,
                   const Layer& texture);
  template <int kChannels>
  void accumulate(const Row& row, float deflection_m, std::size_t& touched_begin, std::size_t& touched_end);
  template <int kChannels>
  void draw(const Row& row, std::span<const double> deflections_m, std::span<std::uint8_t> pixels);

  int channels_;
  cv::Mat texture_;  // CV_8UC4
  std::uint32_t first_row_ = 0;
  std::vector<Row> rows_;
  std::vector<std::uint32_t> sums_;  // of one row: channels and opacity per pixel, 1 / 256 counts
};

}  // namespace roseau::synthesis
