// Arithmetic of Vec3 for the code that builds and measures trees.
#pragma once

#include <cmath>

#include "core/geometry.h"

namespace roseau::structure {

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(double factor, const Vec3& a) { return {factor * a.x, factor * a.y, factor * a.z}; }

inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }
inline double distance(const Vec3& a, const Vec3& b) { return norm(a - b); }
inline bool is_finite(const Vec3& a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

/// The unit vector along `a`; `otherwise` (a unit vector) when `a` has no direction.
inline Vec3 unit(const Vec3& a, const Vec3& otherwise = {0, 0, 1}) {
  const double length = norm(a);
  return length > 1e-12 ? (1 / length) * a : otherwise;
}

/// A unit vector at right angles to the unit vector `axis`: the part of `near` that is, or any where `near` lies along it.
inline Vec3 perpendicular(const Vec3& axis, const Vec3& near) {
  const Vec3 part = near - dot(near, axis) * axis;
  if (norm(part) > 1e-6) return unit(part);
  const Vec3 other = std::abs(axis.x) < 0.8 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  return unit(other - dot(other, axis) * axis);
}

/// `vector` turned about the unit vector `axis`, right-handed.
inline Vec3 turned(const Vec3& vector, const Vec3& axis, double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  return c * vector + s * cross(axis, vector) + ((1 - c) * dot(axis, vector)) * axis;
}

}  // namespace roseau::structure
