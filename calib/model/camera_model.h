// CameraModel: how one camera sees the world: its lens, its pose and the size of its pictures. Lens models are mrcal's, so
// that every mrcal tool reads our models and we read theirs (model_file.h).
//
// World frame: metres. Camera frame: x right, y down, z forward along the optical axis. Image points: the centre of the upper
// left pixel is (0, 0), as in mrcal and OpenCV.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/geometry.h"
#include "core/result.h"
#include "core/sample.h"

namespace roseau::calib {

/// mrcal's LENSMODEL_PINHOLE, _OPENCV4, _OPENCV5 and _OPENCV8.
enum class Lens : std::uint8_t { pinhole, opencv4, opencv5, opencv8 };

std::string_view to_string(Lens lens);  // "LENSMODEL_OPENCV5"
Result<Lens> lens_from_string(std::string_view name);
/// Number of intrinsics: 4, 8, 9 or 12.
std::size_t intrinsics_count(Lens lens);

struct CameraModel {
  static constexpr std::size_t kMaxIntrinsics = 12;

  Lens lens = Lens::pinhole;
  std::uint32_t width = 0;   // px
  std::uint32_t height = 0;  // px
  /// fx fy cx cy in pixels, then k1 k2 p1 p2 k3 k4 k5 k6: as many as the lens has, the rest is ignored.
  std::array<double, kMaxIntrinsics> intrinsics{};
  std::array<double, 9> rotation_camera_from_world{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major
  Vec3 position_in_world_m;                                                     // of the centre of projection

  double fx_px() const { return intrinsics[0]; }
  double fy_px() const { return intrinsics[1]; }
  double cx_px() const { return intrinsics[2]; }
  double cy_px() const { return intrinsics[3]; }
  std::span<const double> used_intrinsics() const { return std::span(intrinsics).first(intrinsics_count(lens)); }
};

/// A point of the world in the camera's frame, and back.
Vec3 to_camera(const CameraModel& camera, const Vec3& point_in_world);
Vec3 to_world(const CameraModel& camera, const Vec3& point_in_camera);

/// Names what makes a model unusable: no size, focal lengths that are not positive, numbers that are not finite, a matrix that
/// is no rotation.
Result<void> check(const CameraModel& camera);

/// An upright camera without distortion at `position` whose optical axis goes through `target`: square pixels, principal point
/// in the middle. The axis must not be vertical.
CameraModel look_at(std::uint32_t width, std::uint32_t height, double focal_length_px, const Vec3& position_in_world_m,
                    const Vec3& target_in_world_m);

/// The message's form of a model: pinhole and Brown-Conrady. OPENCV8's k4 k5 k6 have no place in it: unsupported unless zero.
Result<CameraCalibration> to_calibration(const CameraModel& camera);
/// OPENCV5, or pinhole where all distortion is zero. An uncalibrated message (fx == 0) is refused.
Result<CameraModel> from_calibration(const CameraCalibration& calibration);

}  // namespace roseau::calib
