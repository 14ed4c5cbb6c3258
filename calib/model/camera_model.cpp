#include "calib/model/camera_model.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace roseau::calib {

namespace {

using Rotation = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Eigen::Vector3d vector(const Vec3& v) { return {v.x, v.y, v.z}; }
Vec3 vec3(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Eigen::Map<const Rotation> rotation(const CameraModel& camera) {
  return Eigen::Map<const Rotation>(camera.rotation_camera_from_world.data());
}

constexpr std::array<std::pair<Lens, std::string_view>, 4> kLensNames{{{Lens::pinhole, "LENSMODEL_PINHOLE"},
                                                                       {Lens::opencv4, "LENSMODEL_OPENCV4"},
                                                                       {Lens::opencv5, "LENSMODEL_OPENCV5"},
                                                                       {Lens::opencv8, "LENSMODEL_OPENCV8"}}};

constexpr double kRotationTolerance = 1e-6;

}  // namespace

std::string_view to_string(Lens lens) { return kLensNames.at(static_cast<std::size_t>(lens)).second; }

Result<Lens> lens_from_string(std::string_view name) {
  for (const auto& [lens, its_name] : kLensNames) {
    if (its_name == name) return lens;
  }
  return Error{ErrorCode::unsupported,
               fmt::format("lens model \"{}\" is not known here: use LENSMODEL_PINHOLE, _OPENCV4, _OPENCV5 or _OPENCV8", name)};
}

std::size_t intrinsics_count(Lens lens) {
  constexpr std::array<std::size_t, 4> kCounts{4, 8, 9, 12};
  return kCounts.at(static_cast<std::size_t>(lens));
}

Vec3 to_camera(const CameraModel& camera, const Vec3& point_in_world) {
  return vec3(rotation(camera) * (vector(point_in_world) - vector(camera.position_in_world_m)));
}

Vec3 to_world(const CameraModel& camera, const Vec3& point_in_camera) {
  return vec3(rotation(camera).transpose() * vector(point_in_camera) + vector(camera.position_in_world_m));
}

Result<void> check(const CameraModel& camera) {
  const auto wrong = [](const char* what) { return Error{ErrorCode::invalid_argument, fmt::format("camera model: {}", what)}; };
  if (camera.width == 0 || camera.height == 0) return wrong("the picture has no size");
  if (!std::ranges::all_of(camera.used_intrinsics(), [](double value) { return std::isfinite(value); })) {
    return wrong("an intrinsic parameter is not a finite number");
  }
  if (!(camera.fx_px() > 0 && camera.fy_px() > 0)) return wrong("focal lengths must be positive");
  if (!vector(camera.position_in_world_m).allFinite()) return wrong("the position is not finite");
  const Rotation r = rotation(camera);
  const Rotation deviation = r * r.transpose() - Rotation::Identity();
  if (!(deviation.cwiseAbs().maxCoeff() < kRotationTolerance && r.determinant() > 0)) {
    return wrong("the orientation is not a rotation");
  }
  return {};
}

CameraModel look_at(std::uint32_t width, std::uint32_t height, double focal_length_px, const Vec3& position_in_world_m,
                    const Vec3& target_in_world_m) {
  const Eigen::Vector3d forward = (vector(target_in_world_m) - vector(position_in_world_m)).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  ROSEAU_CHECK(std::abs(right.norm() - 1) < kRotationTolerance);
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.intrinsics = {focal_length_px, focal_length_px, (width - 1) / 2.0, (height - 1) / 2.0};
  camera.position_in_world_m = position_in_world_m;
  Eigen::Map<Rotation> r(camera.rotation_camera_from_world.data());
  r.row(0) = right;
  r.row(1) = forward.cross(right);
  r.row(2) = forward;
  return camera;
}

Result<CameraCalibration> to_calibration(const CameraModel& camera) {
  const std::span<const double> used = camera.used_intrinsics();
  if (std::ranges::any_of(used.subspan(std::min<std::size_t>(9, used.size())), [](double value) { return value != 0; })) {
    return Error{ErrorCode::unsupported,
                 fmt::format("a {} with k4, k5 or k6 cannot be written as pinhole with five distortion numbers: "
                             "fit LENSMODEL_OPENCV5 to it",
                             to_string(camera.lens))};
  }
  CameraCalibration calibration;
  calibration.width = camera.width;
  calibration.height = camera.height;
  calibration.fx_px = camera.fx_px();
  calibration.fy_px = camera.fy_px();
  calibration.cx_px = camera.cx_px();
  calibration.cy_px = camera.cy_px();
  const std::span<const double> distortion = used.subspan(4, std::min<std::size_t>(5, used.size() - 4));
  std::ranges::copy(distortion, calibration.distortion.begin());
  calibration.rotation_camera_from_world = camera.rotation_camera_from_world;
  calibration.position_in_world_m = camera.position_in_world_m;
  return calibration;
}

Result<CameraModel> from_calibration(const CameraCalibration& calibration) {
  CameraModel camera;
  const bool distorted = std::ranges::any_of(calibration.distortion, [](double value) { return value != 0; });
  camera.lens = distorted ? Lens::opencv5 : Lens::pinhole;
  camera.width = calibration.width;
  camera.height = calibration.height;
  camera.intrinsics = {calibration.fx_px, calibration.fy_px, calibration.cx_px, calibration.cy_px};
  std::ranges::copy(calibration.distortion, camera.intrinsics.begin() + 4);
  camera.rotation_camera_from_world = calibration.rotation_camera_from_world;
  camera.position_in_world_m = calibration.position_in_world_m;
  if (const Result<void> checked = check(camera); !checked) return checked.error();
  return camera;
}

}  // namespace roseau::calib
