#include "drivers/wire/rotations.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace roseau::wire {

namespace {

constexpr double kTolerance = 0.05;
constexpr double kRadiansPerDegree = std::numbers::pi / 180;

double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

bool is_rotation(const Matrix3& m) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(std::abs(std::sqrt(dot(m[i], m[i])) - 1) <= kTolerance)) return false;
    if (!(std::abs(dot(m[i], m[(i + 1) % 3])) <= kTolerance)) return false;
  }
  const double determinant = m[0].x * (m[1].y * m[2].z - m[1].z * m[2].y) - m[0].y * (m[1].x * m[2].z - m[1].z * m[2].x) +
                             m[0].z * (m[1].x * m[2].y - m[1].y * m[2].x);
  return determinant > 0;
}

}  // namespace

Quaternion quaternion_from_angles_deg(double azimuth_deg, double elevation_deg, double roll_deg) {
  const double ca = std::cos(azimuth_deg * kRadiansPerDegree / 2);
  const double sa = std::sin(azimuth_deg * kRadiansPerDegree / 2);
  const double ce = std::cos(elevation_deg * kRadiansPerDegree / 2);
  const double se = std::sin(elevation_deg * kRadiansPerDegree / 2);
  const double cr = std::cos(roll_deg * kRadiansPerDegree / 2);
  const double sr = std::sin(roll_deg * kRadiansPerDegree / 2);
  return {.w = ca * ce * cr + sa * se * sr,
          .x = ca * ce * sr - sa * se * cr,
          .y = ca * se * cr + sa * ce * sr,
          .z = sa * ce * cr - ca * se * sr};
}

Angles angles_from_quaternion(const Quaternion& rotation) {
  const Matrix3 m = matrix_from_quaternion(rotation);
  return {.azimuth_deg = std::atan2(m[1].x, m[0].x) / kRadiansPerDegree,
          .elevation_deg = std::asin(std::clamp(0.0 - m[2].x, -1.0, 1.0)) / kRadiansPerDegree,
          .roll_deg = std::atan2(m[2].y, m[2].z) / kRadiansPerDegree};
}

Matrix3 matrix_from_quaternion(const Quaternion& q) {
  return {Vec3{1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y - q.w * q.z), 2 * (q.x * q.z + q.w * q.y)},
          Vec3{2 * (q.x * q.y + q.w * q.z), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z - q.w * q.x)},
          Vec3{2 * (q.x * q.z - q.w * q.y), 2 * (q.y * q.z + q.w * q.x), 1 - 2 * (q.x * q.x + q.y * q.y)}};
}

std::optional<Quaternion> quaternion_from_matrix(const Matrix3& m) {
  if (!is_rotation(m)) return std::nullopt;
  // Shepperd's choice: divide by the largest of the four, so that nothing is lost to cancellation.
  const double trace = m[0].x + m[1].y + m[2].z;
  Quaternion q;
  if (trace >= m[0].x && trace >= m[1].y && trace >= m[2].z) {
    q = {1 + trace, m[2].y - m[1].z, m[0].z - m[2].x, m[1].x - m[0].y};
  } else if (m[0].x >= m[1].y && m[0].x >= m[2].z) {
    q = {m[2].y - m[1].z, 1 + m[0].x - m[1].y - m[2].z, m[0].y + m[1].x, m[0].z + m[2].x};
  } else if (m[1].y >= m[2].z) {
    q = {m[0].z - m[2].x, m[0].y + m[1].x, 1 + m[1].y - m[0].x - m[2].z, m[1].z + m[2].y};
  } else {
    q = {m[1].x - m[0].y, m[0].z + m[2].x, m[1].z + m[2].y, 1 + m[2].z - m[0].x - m[1].y};
  }
  const double length = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return Quaternion{q.w / length, q.x / length, q.y / length, q.z / length};
}

std::optional<Quaternion> normalised(const Quaternion& q) {
  const double length = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  if (!(std::abs(length - 1) <= kTolerance)) return std::nullopt;
  return Quaternion{q.w / length, q.x / length, q.y / length, q.z / length};
}

}  // namespace roseau::wire
