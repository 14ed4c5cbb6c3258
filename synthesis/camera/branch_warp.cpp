#include "synthesis/camera/branch_warp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/check.h"
#include "synthesis/camera/branch_shape.h"
#include "synthesis/camera/pinhole.h"

namespace roseau::synthesis {

namespace {

// The texture is read at 1/256 of its pixels; half a step ahead, so that cutting off rounds.
constexpr double kHalfStep = 0.5 / 256;

// Weights of luma as in JPEG and OpenCV's grey conversion. The grey goes into all channels, so that one sampler serves both.
void to_grey(cv::Mat& texture) {
  for (int y = 0; y < texture.rows; ++y) {
    for (int x = 0; x < texture.cols; ++x) {
      auto& pixel = texture.at<cv::Vec4b>(y, x);
      const auto grey = cv::saturate_cast<uchar>(0.114 * pixel[0] + 0.587 * pixel[1] + 0.299 * pixel[2]);
      pixel = {grey, grey, grey, pixel[3]};
    }
  }
}

// Columns [first, last] of the texture row that are not wholly transparent; first > last when all are.
std::pair<int, int> opaque_columns(const cv::Mat& texture, int y) {
  std::pair<int, int> columns{texture.cols, -1};
  for (int x = 0; x < texture.cols; ++x) {
    if (texture.at<cv::Vec4b>(y, x)[3] == 0) continue;
    columns.first = std::min(columns.first, x);
    columns.second = x;
  }
  return columns;
}

}  // namespace

BranchWarp::BranchWarp(const Layer& texture, const CameraCalibration& camera, double root_z_m, double length_m, double reach_m,
                       int channels)
    : channels_(channels), texture_(texture.pixels.clone()) {
  ROSEAU_CHECK(channels == 1 || channels == 3);
  if (channels == 1) to_grey(texture_);
  double top = std::numeric_limits<double>::infinity();
  double bottom = -top;
  const PlaneWindow& window = texture.window;
  for (const double x_m : {window.left_m - reach_m, window.right_m + reach_m}) {
    top = std::min(top, project(camera, {x_m, texture.plane_y_m, window.top_m}).y);
    bottom = std::max(bottom, project(camera, {x_m, texture.plane_y_m, window.bottom_m}).y);
  }
  first_row_ = static_cast<std::uint32_t>(std::clamp(std::floor(top), 0.0, camera.height - 1.0));
  const auto end_row = static_cast<std::uint32_t>(std::clamp(std::ceil(bottom) + 1, first_row_ + 0.0, camera.height + 0.0));
  for (std::uint32_t y = first_row_; y < end_row; ++y) prepare_row(y, camera, root_z_m, length_m, reach_m, texture);
  sums_.resize(std::size_t{camera.width} * 4);
}

void BranchWarp::prepare_row(std::uint32_t y, const CameraCalibration& camera, double root_z_m, double length_m, double reach_m,
                             const Layer& texture) {
  Row row;
  std::pair<int, int> opaque{texture_.cols, -1};
  float lowest = std::numeric_limits<float>::max();
  float highest = std::numeric_limits<float>::lowest();
  for (std::uint32_t x = 0; x < camera.width; ++x) {
    const Vec3 point = on_plane(camera, {static_cast<double>(x), static_cast<double>(y)}, texture.plane_y_m);
    if (point.x < texture.window.left_m - reach_m || point.x > texture.window.right_m + reach_m) continue;
    if (row.looks.empty()) row.first_x = x;
    const Vec2 at = texture.texture_point(point.x, point.z);
    const double gain = bending_gain((point.z - root_z_m) / length_m) * texture.px_per_m;
    row.looks.push_back({static_cast<float>(at.x + kHalfStep), static_cast<float>(at.y + kHalfStep), static_cast<float>(gain)});
    lowest = std::min(lowest, row.looks.back().y_px);
    highest = std::max(highest, row.looks.back().y_px);
  }
  for (int v = std::max(0, static_cast<int>(lowest)); v < texture_.rows && v <= static_cast<int>(highest) + 1; ++v) {
    const auto columns = opaque_columns(texture_, v);
    opaque = {std::min(opaque.first, columns.first), std::max(opaque.second, columns.second)};
  }
  row.opaque_begin_px = static_cast<float>(opaque.first - 1);
  row.opaque_end_px = static_cast<float>(opaque.second + 1);
  rows_.push_back(std::move(row));
}

// Adds the branch at one deflection, bilinearly sampled, to the row's sums.
template <int kChannels>
void BranchWarp::accumulate(const Row& row, float deflection_m, std::size_t& touched_begin, std::size_t& touched_end) {
  const auto column = [deflection_m](const Look& look) { return look.x_px - deflection_m * look.gain_px_per_m; };
  const auto begin = std::ranges::lower_bound(row.looks, row.opaque_begin_px, {}, column);
  const auto end = std::lower_bound(begin, row.looks.end(), row.opaque_end_px,
                                    [&column](const Look& look, float value) { return column(look) < value; });
  if (begin >= end) return;
  touched_begin = std::min(touched_begin, static_cast<std::size_t>(begin - row.looks.begin()));
  touched_end = std::max(touched_end, static_cast<std::size_t>(end - row.looks.begin()));

  const int last_x = texture_.cols - 2;
  const int last_y = texture_.rows - 2;
  const std::size_t stride = texture_.step;
  std::uint32_t* sums = sums_.data() + (begin - row.looks.begin()) * (kChannels + 1);
  for (auto look = begin; look != end; ++look, sums += kChannels + 1) {
    const int x_fixed = static_cast<int>(column(*look) * 256);
    const int y_fixed = static_cast<int>(look->y_px * 256);
    const int x = x_fixed >> 8;
    const int y = y_fixed >> 8;
    if (x < 0 || y < 0 || x > last_x || y > last_y) continue;
    const std::uint8_t* above = texture_.data + static_cast<std::size_t>(y) * stride + static_cast<std::size_t>(x) * 4;
    const std::uint8_t* below = above + stride;
    if ((above[3] | above[7] | below[3] | below[7]) == 0) continue;
    const auto fx = static_cast<std::uint32_t>(x_fixed & 255);
    const auto fy = static_cast<std::uint32_t>(y_fixed & 255);
    const std::uint32_t w11 = fx * fy;
    const std::uint32_t w10 = 256 * fy - w11;
    const std::uint32_t w01 = 256 * fx - w11;
    const std::uint32_t w00 = 65536 - 256 * fy - w01;
    for (int c = 0; c <= kChannels; ++c) {
      const int s = c == kChannels ? 3 : c;
      sums[c] += (w00 * above[s] + w01 * above[s + 4] + w10 * below[s] + w11 * below[s + 4] + 128) >> 8U;
    }
  }
}

template <int kChannels>
void BranchWarp::draw(const Row& row, std::span<const double> deflections_m, std::span<std::uint8_t> pixels) {
  std::fill_n(sums_.begin(), row.looks.size() * (kChannels + 1), 0U);
  std::size_t begin = row.looks.size();
  std::size_t end = 0;
  for (const double deflection_m : deflections_m) accumulate<kChannels>(row, static_cast<float>(deflection_m), begin, end);

  const float share = 1.0F / (256 * static_cast<float>(deflections_m.size()));
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint32_t* sums = sums_.data() + i * (kChannels + 1);
    if (sums[kChannels] == 0) continue;
    const float clear = 1 - static_cast<float>(sums[kChannels]) * share / 255;
    std::uint8_t* pixel = pixels.data() + (row.first_x + i) * kChannels;
    for (int c = 0; c < kChannels; ++c) {
      const float value = static_cast<float>(sums[c]) * share + static_cast<float>(pixel[c]) * clear + 0.5F;
      pixel[c] = static_cast<std::uint8_t>(std::min(value, 255.0F));
    }
  }
}

void BranchWarp::draw_row(std::uint32_t y, std::span<const double> deflections_m, std::span<std::uint8_t> row) {
  ROSEAU_CHECK(y >= first_row_ && y < end_row() && !deflections_m.empty());
  const Row& prepared = rows_[y - first_row_];
  ROSEAU_CHECK(row.size() >= (prepared.first_x + prepared.looks.size()) * static_cast<std::size_t>(channels_));
  if (channels_ == 1) {
    draw<1>(prepared, deflections_m, row);
  } else {
    draw<3>(prepared, deflections_m, row);
  }
}

}  // namespace roseau::synthesis
