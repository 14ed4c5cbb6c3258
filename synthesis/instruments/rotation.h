// The little algebra that instruments need.
#pragma once

#include <array>
#include <cmath>

#include "core/geometry.h"

namespace roseau::synthesis {

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(const Vec3& a, double factor) { return {a.x * factor, a.y * factor, a.z * factor}; }
inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double length(const Vec3& a) { return std::sqrt(dot(a, a)); }

/// Rows of a 3x3 matrix.
using Rotation = std::array<Vec3, 3>;

inline Vec3 operator*(const Rotation& m, const Vec3& v) { return {dot(m[0], v), dot(m[1], v), dot(m[2], v)}; }
inline Rotation transposed(const Rotation& m) {
  return {Vec3{m[0].x, m[1].x, m[2].x}, Vec3{m[0].y, m[1].y, m[2].y}, Vec3{m[0].z, m[1].z, m[2].z}};
}
inline Rotation operator*(const Rotation& a, const Rotation& b) {
  const Rotation columns = transposed(b);
  Rotation product;
  for (std::size_t i = 0; i < 3; ++i) {
    product[i] = {dot(a[i], columns[0]), dot(a[i], columns[1]), dot(a[i], columns[2])};
  }
  return product;
}
inline Rotation rotation_about_x(double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  return {Vec3{1, 0, 0}, Vec3{0, c, -s}, Vec3{0, s, c}};
}
inline Rotation rotation_about_y(double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  return {Vec3{c, 0, s}, Vec3{0, 1, 0}, Vec3{-s, 0, c}};
}

inline Quaternion conjugated(const Quaternion& q) { return {q.w, -q.x, -q.y, -q.z}; }
inline Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
inline Vec3 rotated(const Quaternion& q, const Vec3& v) {
  const Quaternion turned = q * Quaternion{0, v.x, v.y, v.z} * conjugated(q);
  return {turned.x, turned.y, turned.z};
}
/// Rotation by the vector's length about its direction.
inline Quaternion quaternion_from_rotation_vector(const Vec3& v) {
  const double angle_rad = length(v);
  const double scale = angle_rad > 1e-12 ? std::sin(angle_rad / 2) / angle_rad : 0.5;
  return {std::cos(angle_rad / 2), v.x * scale, v.y * scale, v.z * scale};
}

}  // namespace roseau::synthesis
