#include "structure/mechanics/beam_element.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

namespace roseau::structure {
namespace {

struct GaussPoint {
  double fraction;
  double weight;
};

/// Five-point rule on (0, 1): exact to degree nine.
std::array<GaussPoint, 5> gauss_points() {
  const double near = std::sqrt(5.0 - 2.0 * std::sqrt(10.0 / 7.0)) / 3.0;
  const double far = std::sqrt(5.0 + 2.0 * std::sqrt(10.0 / 7.0)) / 3.0;
  const double near_weight = (322.0 + 13.0 * std::sqrt(70.0)) / 900.0;
  const double far_weight = (322.0 - 13.0 * std::sqrt(70.0)) / 900.0;
  return {{{0.5 * (1 - far), 0.5 * far_weight},
           {0.5 * (1 - near), 0.5 * near_weight},
           {0.5, 0.5 * 128.0 / 225.0},
           {0.5 * (1 + near), 0.5 * near_weight},
           {0.5 * (1 + far), 0.5 * far_weight}}};
}

/// Rows: strain du_x/dx, curvatures d2u_y/dx2 and d2u_z/dx2, twist dpsi_x/dx.
ShapeMatrix beam_strain(double length, double x) {
  const double h1 = (12 * x - 6) / (length * length);
  const double h2 = (6 * x - 4) / length;
  const double h3 = -h1;
  const double h4 = (6 * x - 2) / length;
  ShapeMatrix b = ShapeMatrix::Zero();
  b(0, 0) = b(3, 3) = -1 / length;
  b(0, 6) = b(3, 9) = 1 / length;
  b(1, 1) = b(2, 2) = h1;
  b(1, 7) = b(2, 8) = h3;
  b(1, 5) = h2;
  b(1, 11) = h4;
  b(2, 4) = -h2;
  b(2, 10) = -h4;
  return b;
}

double radius_at(const Beam& beam, double fraction) {
  return beam.start_radius_m + (beam.end_radius_m - beam.start_radius_m) * fraction;
}

}  // namespace

ShapeMatrix beam_shape(double length_m, double x) {
  const double h1 = 1 - x * x * (3 - 2 * x);
  const double h2 = length_m * x * (1 - x) * (1 - x);
  const double h3 = x * x * (3 - 2 * x);
  const double h4 = length_m * x * x * (x - 1);
  ShapeMatrix n = ShapeMatrix::Zero();
  n(0, 0) = n(3, 3) = 1 - x;
  n(0, 6) = n(3, 9) = x;
  n(1, 1) = n(2, 2) = h1;
  n(1, 7) = n(2, 8) = h3;
  n(1, 5) = h2;
  n(1, 11) = h4;
  n(2, 4) = -h2;
  n(2, 10) = -h4;
  return n;
}

ElementMatrix beam_stiffness(const Beam& beam) {
  ElementMatrix stiffness = ElementMatrix::Zero();
  for (const GaussPoint& point : gauss_points()) {
    const double r = radius_at(beam, point.fraction);
    const double area = std::numbers::pi * r * r;
    const double bending = area * r * r / 4;  // second moment of area I; the polar one is twice that
    const Eigen::Vector4d rigidity(beam.young_modulus_pa * area, beam.young_modulus_pa * bending,
                                   beam.young_modulus_pa * bending, beam.shear_modulus_pa * 2 * bending);
    const ShapeMatrix strain = beam_strain(beam.length_m, point.fraction);
    stiffness += point.weight * beam.length_m * strain.transpose() * rigidity.asDiagonal() * strain;
  }
  return 0.5 * (stiffness + stiffness.transpose());
}

ElementMatrix beam_mass(const Beam& beam) {
  ElementMatrix mass = ElementMatrix::Zero();
  for (const GaussPoint& point : gauss_points()) {
    const double r = radius_at(beam, point.fraction);
    const double line_density = beam.density_kg_m3 * std::numbers::pi * r * r;
    const Eigen::Vector4d inertia(line_density, line_density, line_density, line_density * r * r / 2);
    const ShapeMatrix shape = beam_shape(beam.length_m, point.fraction);
    mass += point.weight * beam.length_m * shape.transpose() * inertia.asDiagonal() * shape;
  }
  return 0.5 * (mass + mass.transpose());
}

Eigen::Matrix3d beam_axes(const Eigen::Vector3d& along) {
  Eigen::Matrix3d axes;
  axes.col(0) = along.normalized();
  Eigen::Index least = 0;
  axes.col(0).cwiseAbs().minCoeff(&least);
  axes.col(1) = axes.col(0).cross(Eigen::Vector3d::Unit(least)).normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

}  // namespace roseau::structure
