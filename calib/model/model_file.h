// .cameramodel files: mrcal's format, a Python dictionary in text. Read and written here, with all digits and whatever the
// locale; mrcal's own C writer keeps six decimals and its reader follows the locale's decimal point.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "calib/model/camera_model.h"

namespace roseau::calib {

/// The text of a .cameramodel file. Doubles come back bit by bit, but for the rotation, which the format holds as a rotation
/// vector (to 1e-15).
std::string format_camera_model(const CameraModel& camera);

/// Keys other than the four of the format (lensmodel, intrinsics, extrinsics, imagersize), such as mrcal's optimization_inputs,
/// are skipped. Errors name `source` and the line.
Result<CameraModel> parse_camera_model(std::string_view text, const std::string& source);

Result<CameraModel> read_camera_model(const std::filesystem::path& path);
Result<void> write_camera_model(const std::filesystem::path& path, const CameraModel& camera);

}  // namespace roseau::calib
