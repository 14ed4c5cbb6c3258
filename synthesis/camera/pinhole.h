// Where things of the world appear in a camera's picture: core's CameraCalibration without distortion.
//
// World frame: metres, x east, y north, z up. Camera frame: x right, y down, z forward. Image coordinates here have the
// centre of the upper left pixel at (0, 0), as OpenCV and the calibration do; an ImageRect counts from that pixel's corner.
#pragma once

#include "core/geometry.h"
#include "core/sample.h"

namespace roseau::synthesis {

/// An upright camera at `position` whose optical axis goes through `target`; square pixels, principal point in the middle.
CameraCalibration look_at(std::uint32_t width, std::uint32_t height, double focal_length_px, const Vec3& position_in_world,
                          const Vec3& target_in_world);

/// Image coordinates of a point in front of the camera.
Vec2 project(const CameraCalibration& camera, const Vec3& point_in_world);

/// Distance of a point from the camera's plane, along its optical axis; positive in front.
double depth_m(const CameraCalibration& camera, const Vec3& point_in_world);

/// Direction, in the world, of the ray through an image point; not of unit length.
Vec3 ray_in_world(const CameraCalibration& camera, const Vec2& image_point);

/// Where that ray meets the vertical plane y = `plane_y_m` (a plane facing south); it must not run parallel to it.
Vec3 on_plane(const CameraCalibration& camera, const Vec2& image_point, double plane_y_m);

}  // namespace roseau::synthesis
