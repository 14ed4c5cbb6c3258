#include "synthesis/camera/frame_renderer.h"

#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/check.h"
#include "synthesis/camera/landscape.h"
#include "synthesis/camera/objects.h"
#include "synthesis/camera/pinhole.h"

namespace roseau::synthesis {

namespace {

constexpr double kTextureOversampling = 2;  // texture pixels per picture pixel: bilinear reading is then exact enough
constexpr double kLensBlurPx = 0.8;         // standard deviation, picture pixels: what a good lens and the pixel's area do
constexpr double kReachFactor = 9;          // deflections up to three times the mean wind speed

// Layers are drawn as finely as the camera sees their plane.
class LayerScale {
 public:
  explicit LayerScale(const CameraCalibration& camera) : camera_(camera) {}
  double px_per_m(double plane_y_m) const {
    return kTextureOversampling * camera_.fx_px /
           depth_m(camera_, {camera_.position_in_world_m.x, plane_y_m, camera_.position_in_world_m.z});
  }
  static double blur_px() { return kTextureOversampling * kLensBlurPx; }

 private:
  const CameraCalibration& camera_;
};

// Lays a layer over the picture, seen through the pinhole.
void composite(cv::Mat& picture, const Layer& layer, const CameraCalibration& camera) {
  // The map from picture to texture is a homography: four points give it.
  std::vector<cv::Point2f> in_picture;
  std::vector<cv::Point2f> in_texture;
  for (const double u : {0.0, camera.width - 1.0}) {
    for (const double v : {0.0, camera.height - 1.0}) {
      const Vec3 point = on_plane(camera, {u, v}, layer.plane_y_m);
      const Vec2 texture = layer.texture_point(point.x, point.z);
      in_picture.emplace_back(static_cast<float>(u), static_cast<float>(v));
      in_texture.emplace_back(static_cast<float>(texture.x), static_cast<float>(texture.y));
    }
  }
  const cv::Mat texture_from_picture = cv::getPerspectiveTransform(in_picture, in_texture);
  cv::Mat seen;
  cv::warpPerspective(layer.pixels, seen, texture_from_picture, picture.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                      cv::BORDER_CONSTANT, cv::Scalar(0, 0, 0, 0));
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const auto& over = seen.at<cv::Vec4b>(y, x);
      if (over[3] == 0) continue;
      auto& under = picture.at<cv::Vec3b>(y, x);
      for (int c = 0; c < 3; ++c) under[c] = cv::saturate_cast<uchar>(over[c] + under[c] * (255 - over[3]) / 255.0);
    }
  }
}

cv::Mat paint_backdrop(const Scene& scene, const CameraCalibration& camera) {
  cv::Mat picture = paint_landscape(camera, scene.seed);
  cv::GaussianBlur(picture, picture, {}, kLensBlurPx, kLensBlurPx, cv::BORDER_REPLICATE);
  const LayerScale scale(camera);
  const double blur_px = LayerScale::blur_px();
  composite(picture, draw_barn(scale.px_per_m(42), blur_px), camera);
  composite(picture, draw_fence(scale.px_per_m(9), blur_px, scene.seed), camera);
  const double tree_px_per_m = scale.px_per_m(scene.branch.root_in_world_m.y);
  for (const Layer& layer :
       draw_tree(scene.branch.root_in_world_m, scene.branch.length_m, tree_px_per_m, blur_px, scene.seed)) {
    composite(picture, layer, camera);
  }
  const Vec3& sonic = scene.sonic.position_in_world_m;
  composite(picture, draw_sonic(sonic, scale.px_per_m(sonic.y), blur_px), camera);
  return picture;
}

cv::Mat in_format(const cv::Mat& bgr, PixelFormat format) {
  cv::Mat converted;
  if (format == PixelFormat::mono8) cv::cvtColor(bgr, converted, cv::COLOR_BGR2GRAY);
  if (format == PixelFormat::rgb8) cv::cvtColor(bgr, converted, cv::COLOR_BGR2RGB);
  if (format == PixelFormat::bgr8) converted = bgr;
  ROSEAU_CHECK(!converted.empty());
  return converted;
}

BranchWarp make_branch(const Scene& scene, const CameraCalibration& camera, PixelFormat format) {
  const BranchScene& branch = scene.branch;
  Layer layer = draw_branch(branch.root_in_world_m, branch.length_m, LayerScale(camera).px_per_m(branch.root_in_world_m.y),
                            LayerScale::blur_px(), scene.seed);
  if (format == PixelFormat::rgb8) cv::cvtColor(layer.pixels, layer.pixels, cv::COLOR_BGRA2RGBA);
  return {layer,
          camera,
          branch.root_in_world_m.z,
          branch.length_m,
          kReachFactor * branch.mean_deflection_m,
          format == PixelFormat::mono8 ? 1 : 3};
}

}  // namespace

FrameRenderer::FrameRenderer(const Scene& scene, std::size_t camera_index)
    : calibration_(calibration_of(scene.cameras.at(camera_index))),
      row_bytes_(calibration_.width * bytes_per_pixel(scene.cameras.at(camera_index).format)),
      backdrop_(in_format(paint_backdrop(scene, calibration_), scene.cameras.at(camera_index).format)),
      branch_(make_branch(scene, calibration_, scene.cameras.at(camera_index).format)),
      noise_({scene.cameras.at(camera_index).read_noise_counts, scene.cameras.at(camera_index).shot_noise_gain},
             scatter_bits(scene.seed) + camera_index, row_bytes_),
      row_(row_bytes_) {}

void FrameRenderer::render(std::span<const double> deflections_m, std::uint64_t frame, std::span<std::byte> pixels) {
  ROSEAU_CHECK(pixels.size() >= frame_bytes());
  for (std::uint32_t y = 0; y < calibration_.height; ++y) {
    std::span<const std::uint8_t> clean(backdrop_.ptr<std::uint8_t>(static_cast<int>(y)), row_bytes_);
    if (y >= branch_.first_row() && y < branch_.end_row()) {
      std::memcpy(row_.data(), clean.data(), row_bytes_);
      branch_.draw_row(y, deflections_m, row_);
      clean = row_;
    }
    auto* out = reinterpret_cast<std::uint8_t*>(pixels.data() + y * row_bytes_);
    noise_.apply(clean, frame, y, {out, row_bytes_});
  }
}

}  // namespace roseau::synthesis
