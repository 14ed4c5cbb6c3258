// One straight piece of wood as a three-dimensional Euler-Bernoulli beam element of round section (thesis 6.2.1, with the
// corrected shape functions, G, I and J: docs/errata.md).
//
// Local frame: x along the piece from its parent's end, y and z across. Twelve degrees of freedom: at each end the
// displacements (u_x, u_y, u_z) in metres and the rotation vector (psi_x, psi_y, psi_z) in radians, psi_y = -du_z/dx and
// psi_z = du_y/dx (6.1, 6.2).
//
// The radius runs straight from one end to the other and all integrals are exact for it (five Gauss points: the mass integrand
// is of degree eight). The thesis takes the mean of the two radii; that costs nothing in a cylinder, but turns the fourth order
// of convergence into the second in a tapered branch.
#pragma once

#include <Eigen/Core>

namespace roseau::structure {

using ElementMatrix = Eigen::Matrix<double, 12, 12>;
/// Rows: u_x, u_y, u_z, psi_x at a point of the element; columns: its twelve degrees of freedom.
using ShapeMatrix = Eigen::Matrix<double, 4, 12>;

struct Beam {
  double length_m = 0;
  double start_radius_m = 0;
  double end_radius_m = 0;
  double young_modulus_pa = 0;
  double shear_modulus_pa = 0;
  double density_kg_m3 = 0;
};

/// N of 6.4 at fraction (0 to 1) of the length.
ShapeMatrix beam_shape(double length_m, double fraction);

/// K of 6.6, in the local frame.
ElementMatrix beam_stiffness(const Beam& beam);

/// Consistent M of 6.9, in the local frame: translation of the section, and its turning about the axis.
ElementMatrix beam_mass(const Beam& beam);

/// Columns: the local axes in the frame of `along`, which need not have unit length. A round section leaves y and z free; they
/// depend on the direction alone.
Eigen::Matrix3d beam_axes(const Eigen::Vector3d& along);

}  // namespace roseau::structure
