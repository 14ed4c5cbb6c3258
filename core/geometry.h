// Small fixed-size vectors shared by every folder. Heavier algebra uses Eigen where it is needed.
#pragma once

namespace roseau {

struct Vec2 {
  double x = 0;
  double y = 0;
};

struct Vec3 {
  double x = 0;
  double y = 0;
  double z = 0;
};

/// Rotation as a unit quaternion, Hamilton's convention: rotates vectors of the first named frame's axes ("b_from_a" takes a's
/// coordinates to b's).
struct Quaternion {
  double w = 1;
  double x = 0;
  double y = 0;
  double z = 0;
};

/// Axis-aligned rectangle in an image: pixels, origin at the upper left corner of the upper left pixel.
struct ImageRect {
  double x = 0;
  double y = 0;
  double width = 0;
  double height = 0;
};

/// Symmetric 2x2 covariance of a (x, y) quantity, in that quantity's unit squared.
struct Covariance2 {
  double xx = 0;
  double xy = 0;
  double yy = 0;
};

/// Symmetric 3x3 covariance of an (x, y, z) quantity, in that quantity's unit squared.
struct Covariance3 {
  double xx = 0;
  double xy = 0;
  double xz = 0;
  double yy = 0;
  double yz = 0;
  double zz = 0;
};

}  // namespace roseau
