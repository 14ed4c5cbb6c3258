// The little algebra that drawing needs, on core's vectors.
#pragma once

#include <array>
#include <cmath>

#include "core/geometry.h"

namespace roseau::render {

using Matrix3 = std::array<double, 9>;  // row-major

constexpr Vec3 add(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr Vec3 subtract(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
constexpr Vec3 times(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
constexpr double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const Vec3& a) { return std::sqrt(dot(a, a)); }

/// Zero stays zero.
inline Vec3 unit(const Vec3& a) {
  const double its_length = length(a);
  return its_length > 0 ? times(1 / its_length, a) : a;
}

constexpr Vec3 rotated(const Matrix3& m, const Vec3& v) {
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z, m[6] * v.x + m[7] * v.y + m[8] * v.z};
}

constexpr Matrix3 product(const Matrix3& a, const Matrix3& b) {
  Matrix3 result{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      result[3 * row + column] = a[3 * row] * b[column] + a[3 * row + 1] * b[3 + column] + a[3 * row + 2] * b[6 + column];
    }
  }
  return result;
}

/// Rotation by a rotation vector (Rodrigues).
inline Matrix3 rotation(const Vec3& rotation_rad) {
  const double angle2 = dot(rotation_rad, rotation_rad);
  const double angle = std::sqrt(angle2);
  const double s = angle > 1e-8 ? std::sin(angle) / angle : 1;
  const double c = angle > 1e-4 ? (1 - std::cos(angle)) / angle2 : 0.5;
  const auto& [x, y, z] = rotation_rad;
  return {1 - c * (y * y + z * z), c * x * y - s * z,       c * x * z + s * y,  //
          c * x * y + s * z,       1 - c * (x * x + z * z), c * y * z - s * x,  //
          c * x * z - s * y,       c * y * z + s * x,       1 - c * (x * x + y * y)};
}

/// A unit quaternion's rotation matrix.
constexpr Matrix3 rotation(const Quaternion& q) {
  return {1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y - q.w * q.z),     2 * (q.x * q.z + q.w * q.y),
          2 * (q.x * q.y + q.w * q.z),     1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z - q.w * q.x),
          2 * (q.x * q.z - q.w * q.y),     2 * (q.y * q.z + q.w * q.x),     1 - 2 * (q.x * q.x + q.y * q.y)};
}

}  // namespace roseau::render
