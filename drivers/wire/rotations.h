// Rotations as trackers print them: angles, direction cosines, quaternions.
#pragma once

#include <array>
#include <optional>

#include "core/geometry.h"

namespace roseau::wire {

/// Rotation about z by azimuth, then about the new y by elevation, then about the new x by roll.
Quaternion quaternion_from_angles_deg(double azimuth_deg, double elevation_deg, double roll_deg);

struct Angles {
  double azimuth_deg = 0;    // -180 .. 180
  double elevation_deg = 0;  // -90 .. 90
  double roll_deg = 0;       // -180 .. 180
};
Angles angles_from_quaternion(const Quaternion& rotation);

/// Rows of the rotation's matrix.
using Matrix3 = std::array<Vec3, 3>;
Matrix3 matrix_from_quaternion(const Quaternion& rotation);

/// Nothing when the matrix is no rotation, or not nearly (rows longer or shorter than 1, or not square to each other, by more
/// than 0.05; a reflection).
std::optional<Quaternion> quaternion_from_matrix(const Matrix3& matrix);

/// The quaternion made exactly of length 1; nothing when it is off by more than 0.05 or not finite.
std::optional<Quaternion> normalised(const Quaternion& quaternion);

}  // namespace roseau::wire
