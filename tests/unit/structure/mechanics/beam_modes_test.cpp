#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <functional>

#include "structure/mechanics/beam_element.h"
#include "structure/mechanics/modes.h"
#include "tests/unit/structure/mechanics/trees.h"

namespace roseau::structure {
namespace {

using testing::add_branch;
using testing::crooked_tree;
using testing::pole;

constexpr double kPi = std::numbers::pi;

struct Analysis {
  BeamStructure structure;
  Modes modes;
};

Analysis analyse(const TreeModel& tree, std::size_t mode_count, const BeamOptions& options = {}) {
  auto structure = assemble_beams(tree, options);
  EXPECT_TRUE(structure.has_value()) << structure.error().message;
  auto modes = first_modes(*structure, {.mode_count = mode_count});
  EXPECT_TRUE(modes.has_value()) << modes.error().message;
  return {std::move(*structure), std::move(*modes)};
}

double angular_frequency(const Modes& modes, Eigen::Index mode) { return std::sqrt(modes.stiffness_per_s2[mode]); }

/// Share of a mode's displacements (not its rotations) along an axis.
double share_along(const Eigen::VectorXd& shape, Eigen::Index axis) {
  double along = 0;
  double all = 0;
  for (Eigen::Index row = 0; row < shape.size(); row += 6) {
    along += shape[row + axis] * shape[row + axis];
    all += shape.segment(row, 3).squaredNorm();
  }
  return along / all;
}

/// First zeros of a function that has poles, too.
std::vector<double> zeros(const std::function<double(double)>& f, double from, double step, std::size_t count) {
  std::vector<double> found;
  for (double a = from; found.size() < count; a += step) {
    double low = a;
    double high = a + step;
    if (f(low) * f(high) > 0) continue;
    const double outside = std::min(std::abs(f(low)), std::abs(f(high)));
    for (int i = 0; i < 200; ++i) {
      const double middle = (low + high) / 2;
      (f(low) * f(middle) <= 0 ? high : low) = middle;
    }
    if (std::abs(f(low)) < outside) found.push_back(low);
  }
  return found;
}

// ---- the element --------------------------------------------------------------------------------------------------------

TEST(BeamElement, ShapesAreOneAtTheirEndAndZeroAtTheOther) {
  const ShapeMatrix start = beam_shape(0.7, 0);
  const ShapeMatrix end = beam_shape(0.7, 1);
  EXPECT_TRUE((start.block<4, 4>(0, 0).isApprox(Eigen::Matrix4d::Identity(), 1e-15)));
  EXPECT_LT((start.block<4, 6>(0, 6).cwiseAbs().maxCoeff()), 1e-15);
  EXPECT_TRUE((end.block<4, 4>(0, 6).isApprox(Eigen::Matrix4d::Identity(), 1e-15)));
  EXPECT_LT((end.block<4, 6>(0, 0).cwiseAbs().maxCoeff()), 1e-15);
}

TEST(BeamElement, SlopesAreTheRotations) {
  const double step = 1e-6;
  const double length = 0.7;
  const ShapeMatrix slope = (beam_shape(length, step) - beam_shape(length, 0)) / (step * length);
  EXPECT_NEAR(slope(1, 5), 1, 1e-5);   // psi_z = du_y/dx
  EXPECT_NEAR(slope(2, 4), -1, 1e-5);  // psi_y = -du_z/dx
  const ShapeMatrix far = (beam_shape(length, 1) - beam_shape(length, 1 - step)) / (step * length);
  EXPECT_NEAR(far(1, 11), 1, 1e-5);
  EXPECT_NEAR(far(2, 10), -1, 1e-5);
}

Beam tapered_beam() {
  return {.length_m = 0.8,
          .start_radius_m = 0.03,
          .end_radius_m = 0.01,
          .young_modulus_pa = 9e9,
          .shear_modulus_pa = 9e9 / 2.6,
          .density_kg_m3 = 870};
}

/// Rigid motions of an element: three displacements, three small turns about its start.
Eigen::Matrix<double, 12, 6> rigid_motions(double length) {
  Eigen::Matrix<double, 12, 6> rigid = Eigen::Matrix<double, 12, 6>::Zero();
  rigid.topRows<6>().setIdentity();
  rigid.bottomRows<6>().setIdentity();
  rigid(8, 4) = -length;  // turned about y, the far end goes down
  rigid(7, 5) = length;
  return rigid;
}

TEST(BeamElement, RigidMotionCostsNothing) {
  const Beam beam = tapered_beam();
  const ElementMatrix stiffness = beam_stiffness(beam);
  const Eigen::Matrix<double, 12, 6> forces = stiffness * rigid_motions(beam.length_m);
  EXPECT_LT(forces.cwiseAbs().maxCoeff(), 1e-12 * stiffness.cwiseAbs().maxCoeff());
}

TEST(BeamElement, RigidMotionHasTheWoodsMassAndInertia) {
  const Beam beam = tapered_beam();
  const Eigen::Matrix<double, 6, 6> rigid =
      rigid_motions(beam.length_m).transpose() * beam_mass(beam) * rigid_motions(beam.length_m);
  // Closed integrals of density pi r(x)^2 {1, x, x^2} and density pi r^4 / 2 along a cone.
  const double a = beam.start_radius_m;
  const double d = beam.end_radius_m - a;
  const double base = beam.density_kg_m3 * kPi;
  const double length = beam.length_m;
  const double mass = base * length * (a * a + a * d + d * d / 3);
  const double moment = base * length * length * (a * a / 2 + 2 * a * d / 3 + d * d / 4);
  const double inertia = base * std::pow(length, 3) * (a * a / 3 + a * d / 2 + d * d / 5);
  const double polar = base / 2 * length * (std::pow(a + d, 5) - std::pow(a, 5)) / (5 * d);
  for (Eigen::Index axis = 0; axis < 3; ++axis) EXPECT_NEAR(rigid(axis, axis), mass, 1e-12 * mass);
  EXPECT_NEAR(rigid(1, 5), moment, 1e-12 * moment);
  EXPECT_NEAR(rigid(2, 4), -moment, 1e-12 * moment);
  EXPECT_NEAR(rigid(5, 5), inertia, 1e-12 * inertia);
  EXPECT_NEAR(rigid(3, 3), polar, 1e-12 * polar);
}

TEST(BeamElement, TipForceBendsByTheTextbookAmount) {
  const Beam beam{.length_m = 0.5,
                  .start_radius_m = 0.01,
                  .end_radius_m = 0.01,
                  .young_modulus_pa = 1e10,
                  .shear_modulus_pa = 1e10 / 2.6,
                  .density_kg_m3 = 1000};
  const Eigen::Matrix<double, 6, 6> free_end = beam_stiffness(beam).bottomRightCorner<6, 6>();
  const Eigen::Matrix<double, 6, 6> flexibility = free_end.inverse();
  const double second_moment = kPi * 1e-8 / 4;  // I = pi r^4 / 4
  EXPECT_NEAR(flexibility(1, 1), 0.125 / (3 * 1e10 * second_moment), 1e-9);
  EXPECT_NEAR(flexibility(2, 2), 0.125 / (3 * 1e10 * second_moment), 1e-9);
  EXPECT_NEAR(flexibility(0, 0), 0.5 / (1e10 * kPi * 1e-4), 1e-16);
  EXPECT_NEAR(flexibility(3, 3), 0.5 / (1e10 / 2.6 * 2 * second_moment), 1e-6 * flexibility(3, 3));  // J = 2 I, G = E / 2.6
}

// ---- closed forms -------------------------------------------------------------------------------------------------------

constexpr double kCantileverRoots[] = {1.8751040687119611, 4.6940911329741746, 7.8547574382376126};

double pole_frequency(std::size_t which, double length_m = 2, double radius_m = 0.02) {
  const double root = kCantileverRoots[which] / length_m;
  return root * root * std::sqrt(1e10 * radius_m * radius_m / 4 / 1000);
}

TEST(Modes, UniformCantilever) {
  const Analysis pole20 = analyse(pole(20), 6);
  for (std::size_t i = 0; i < 3; ++i) {
    const double truth = pole_frequency(i);
    for (std::size_t twin = 0; twin < 2; ++twin) {  // once in x, once in y
      const auto mode = static_cast<Eigen::Index>(2 * i + twin);
      EXPECT_NEAR(angular_frequency(pole20.modes, mode), truth, 1e-3 * truth);
      EXPECT_GT(share_along(pole20.modes.shapes.col(mode), static_cast<Eigen::Index>(twin)), 0.999999);
    }
  }
}

/// Slope of log error against log element count between two meshes.
double order(double coarse_error, double fine_error) { return std::log2(coarse_error / fine_error); }

TEST(Modes, CantileverConvergesWithTheFourthPowerOfTheElementLength) {
  const Analysis coarse = analyse(pole(8), 6);
  const Analysis fine = analyse(pole(16), 6);
  for (std::size_t i = 0; i < 3; ++i) {
    const double truth = pole_frequency(i);
    const auto mode = static_cast<Eigen::Index>(2 * i);
    EXPECT_NEAR(order(angular_frequency(coarse.modes, mode) - truth, angular_frequency(fine.modes, mode) - truth), 4, 0.1) << i;
  }
}

TreeModel cone(std::size_t segments) {
  auto tree = cantilever({.length_m = 3, .start_radius_m = 0.04, .end_radius_m = 0.008, .segment_count = segments});
  ROSEAU_CHECK(tree.has_value());
  return *tree;
}

/// Clamped at its thick end: with xi the distance from the cone's point (1 at the foot, a at the tip),
/// w = [A J2(z) + B Y2(z) + C I2(z) + D K2(z)] / xi, z = 2 p sqrt(xi)   (Mabie and Rogers 1972; Bessel's equation).
double cone_determinant(double p, double a) {
  const double z1 = 2 * p;
  const double za = 2 * p * std::sqrt(a);
  using std::cyl_bessel_i, std::cyl_bessel_j, std::cyl_bessel_k, std::cyl_neumann;
  Eigen::Matrix4d rows;
  rows << cyl_bessel_j(2, z1), cyl_neumann(2, z1), cyl_bessel_i(2, z1), cyl_bessel_k(2, z1),  // w
      -cyl_bessel_j(3, z1), -cyl_neumann(3, z1), cyl_bessel_i(3, z1), -cyl_bessel_k(3, z1),   // w'
      cyl_bessel_j(4, za), cyl_neumann(4, za), cyl_bessel_i(4, za), cyl_bessel_k(4, za),      // moment
      cyl_bessel_j(3, za), cyl_neumann(3, za), cyl_bessel_i(3, za), -cyl_bessel_k(3, za);     // shear
  return rows.determinant();
}

std::vector<double> cone_frequencies() {
  const double full_length = 3 / (1 - 0.2);
  std::vector<double> frequencies;
  for (const double p : zeros([](double root) { return cone_determinant(root, 0.2); }, 1, 0.05, 3)) {
    frequencies.push_back(p * p / (full_length * full_length) * std::sqrt(1e10 * 0.04 * 0.04 / 4 / 1000));
  }
  return frequencies;
}

TEST(Modes, TaperedCantileverAgainstBessel) {
  // The determinant itself: a full cone has 8.719 (Conway, Becker and Dubil 1964).
  const double p = zeros([](double root) { return cone_determinant(root, 1e-3); }, 1, 0.05, 1)[0];
  EXPECT_NEAR(p * p, 8.719, 0.002);

  const std::vector<double> truth = cone_frequencies();
  const Analysis cone20 = analyse(cone(20), 6);
  const Analysis cone40 = analyse(cone(40), 6);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto mode = static_cast<Eigen::Index>(2 * i);
    EXPECT_NEAR(angular_frequency(cone20.modes, mode), truth[i], 1e-4 * truth[i]);
    EXPECT_NEAR(order(angular_frequency(cone20.modes, mode) - truth[i], angular_frequency(cone40.modes, mode) - truth[i]), 4,
                0.3);
  }
}

TEST(Modes, MeanRadiusInEachElementConvergesWithTheSecondPowerOnly) {
  const auto stepped = [](std::size_t segments) {
    TreeModel tree = cone(segments);
    for (auto& node : tree.nodes) node.start_radius_m = node.end_radius_m = (node.start_radius_m + node.end_radius_m) / 2;
    return tree;
  };
  const double truth = cone_frequencies()[0];
  const double coarse = std::abs(angular_frequency(analyse(stepped(10), 1).modes, 0) - truth);
  const double fine = std::abs(angular_frequency(analyse(stepped(20), 1).modes, 0) - truth);
  EXPECT_NEAR(order(coarse, fine), 2, 0.2);
}

/// Index of the first mode whose displacements lie along z (axial), or that has next to none beside its turning (torsion).
Eigen::Index first_mode_where(const Modes& modes, const std::function<bool(const Eigen::VectorXd&)>& is_it) {
  for (Eigen::Index i = 0; i < modes.shapes.cols(); ++i) {
    if (is_it(modes.shapes.col(i))) return i;
  }
  ADD_FAILURE() << "no such mode";
  return 0;
}

double first_axial(std::size_t segments) {
  const Modes modes = analyse(pole(segments), 6 * segments).modes;
  return angular_frequency(modes, first_mode_where(modes, [](const Eigen::VectorXd& v) { return share_along(v, 2) > 0.99; }));
}

double first_torsion(std::size_t segments) {
  const Modes modes = analyse(pole(segments), 6 * segments).modes;
  const auto turns = [](const Eigen::VectorXd& v) {
    double turning = 0;
    double moving = 0;
    for (Eigen::Index row = 0; row < v.size(); row += 6) {
      turning += v[row + 5] * v[row + 5];
      moving += v.segment(row, 5).squaredNorm();
    }
    return turning > 100 * moving;
  };
  return angular_frequency(modes, first_mode_where(modes, turns));
}

TEST(Modes, AxialAndTorsionOfAPole) {
  const double axial = kPi / 4 * std::sqrt(1e10 / 1000);
  const double torsion = kPi / 4 * std::sqrt(1e10 / 2.6 / 1000);
  EXPECT_NEAR(first_axial(20), axial, 1e-3 * axial);
  EXPECT_NEAR(first_torsion(20), torsion, 1e-3 * torsion);
  EXPECT_NEAR(order(first_axial(5) - axial, first_axial(10) - axial), 2, 0.1);
  EXPECT_NEAR(order(first_torsion(5) - torsion, first_torsion(10) - torsion), 2, 0.1);
}

/// Exact force and moment at x = 0 of a vibrating beam per unit of displacement and slope there; its far end is clamped or
/// free.
Eigen::Matrix2d end_stiffness(double k, double length, double rigidity, bool clamped) {
  const double c = std::cos(k * length);
  const double s = std::sin(k * length);
  const double ch = std::cosh(k * length);
  const double sh = std::sinh(k * length);
  Eigen::Matrix4d conditions;  // of w = A cos kx + B sin kx + C cosh kx + D sinh kx
  conditions.row(0) << 1, 0, 1, 0;
  conditions.row(1) << 0, k, 0, k;
  if (clamped) {
    conditions.row(2) << c, s, ch, sh;
    conditions.row(3) << -s, c, sh, ch;
  } else {
    conditions.row(2) << -c, -s, ch, sh;
    conditions.row(3) << s, -c, sh, ch;
  }
  Eigen::Matrix<double, 2, 4> loads;  // shear EI w''' and moment -EI w'' that move the end
  loads << 0, -k * k * k, 0, k * k * k, k * k, 0, -k * k, 0;
  const Eigen::Matrix<double, 4, 2> coefficients = conditions.inverse().leftCols<2>();
  return rigidity * loads * coefficients;
}

/// A T: a trunk and two arms across its top. Sway in the plane of the T: the arms bend as mirror images of each other.
TEST(Modes, SymmetricTAgainstItsTranscendentalEquation) {
  const double height = 2;
  const double arm = 1.2;
  const double radius = 0.02;
  const double arm_radius = 0.015;
  TreeModel tree = pole(20, height, radius);
  add_branch(tree, 20, {arm, 0, 0}, arm_radius, arm_radius, 20);
  add_branch(tree, 20, {-arm, 0, 0}, arm_radius, arm_radius, 20);
  const Modes modes = analyse(tree, 16).modes;

  const auto determinant = [&](double w) {
    const auto rigidity = [](double r) { return 1e10 * kPi * std::pow(r, 4) / 4; };
    const auto wave_number = [&](double r) { return std::sqrt(w / std::sqrt(1e10 * r * r / 4 / 1000)); };
    // From the joint down: x' = -z; displacement is the same, slope changes sign twice over (force direction, too).
    const Eigen::Matrix2d trunk = end_stiffness(wave_number(radius), height, rigidity(radius), true);
    const Eigen::Matrix2d side = end_stiffness(wave_number(arm_radius), arm, rigidity(arm_radius), false);
    const double k = w / std::sqrt(1e10 / 1000);
    const double push = -1e10 * kPi * arm_radius * arm_radius * k * std::tan(k * arm);
    Eigen::Matrix2d joint = trunk;
    joint(0, 0) += 2 * push;
    joint(1, 1) += 2 * side(1, 1);
    return joint.determinant();
  };
  const std::vector<double> truth = zeros(determinant, 0.5, 0.37, 3);

  std::vector<double> sway;
  for (Eigen::Index i = 0; i < modes.shapes.cols(); ++i) {
    const Eigen::VectorXd shape = modes.shapes.col(i);
    const Eigen::Index joint = static_cast<Eigen::Index>(60 - 20) * 6;
    const bool in_plane = share_along(shape, 1) < 1e-6;
    const bool mirrored = std::abs(shape[joint + 4]) > 1e-6 * shape.cwiseAbs().maxCoeff();
    if (in_plane && mirrored) sway.push_back(angular_frequency(modes, i));
  }
  ASSERT_GE(sway.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(sway[i], truth[i], 1e-4 * truth[i]);
}

// ---- the search ---------------------------------------------------------------------------------------------------------

Eigen::VectorXd dense_eigenvalues(const BeamStructure& structure) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      Eigen::MatrixXd(structure.stiffness), Eigen::MatrixXd(structure.mass), Eigen::EigenvaluesOnly);
  return solver.eigenvalues();
}

TreeModel fine_crooked_tree() {
  TreeModel tree = crooked_tree();
  for (std::size_t i = 3; i < 9; ++i) add_branch(tree, i, {0.3, 0.05 * static_cast<double>(i), 0.4}, 0.004, 0.002, 4);
  return tree;
}

TEST(Modes, AgreeWithADenseSolver) {
  const Analysis sparse = analyse(fine_crooked_tree(), 25);
  ASSERT_GT(sparse.structure.dof_count(), 200);
  const Eigen::VectorXd truth = dense_eigenvalues(sparse.structure).head(25);
  EXPECT_LT(((sparse.modes.stiffness_per_s2 - truth).array() / truth.array()).abs().maxCoeff(), 1e-8);
  EXPECT_LT(sparse.modes.largest_residual, 1e-8);
  EXPECT_LT(sparse.modes.largest_imbalance, 1e-12);
  const Eigen::MatrixXd gram = sparse.modes.shapes.transpose() * (sparse.structure.mass * sparse.modes.shapes);
  EXPECT_LT((gram - Eigen::MatrixXd::Identity(25, 25)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Modes, FillNothingIn) {
  const auto structure = assemble_beams(fine_crooked_tree(), {});
  ASSERT_TRUE(structure);
  const Eigen::Index nodes = static_cast<Eigen::Index>(structure->node_count) - 1;
  // 36 per node and 36 on either side of the diagonal per segment that does not stand on the foot.
  EXPECT_LE(structure->stiffness.nonZeros(), nodes * 36 + (nodes - 1) * 72);
}

TEST(Modes, NoneOfManyTwinsIsLeftOut) {
  TreeModel tree = pole(3, 1, 0.05);
  for (int i = 0; i < 14; ++i) {
    const double angle = 2 * kPi * i / 14;
    add_branch(tree, 3, {std::cos(angle), std::sin(angle), 0.3}, 0.01, 0.01, 3);
  }
  const Analysis star = analyse(tree, 30);
  ASSERT_GT(star.structure.dof_count(), 200);
  const Eigen::VectorXd truth = dense_eigenvalues(star.structure).head(30);
  EXPECT_LT(((star.modes.stiffness_per_s2 - truth).array() / truth.array()).abs().maxCoeff(), 1e-8);
}

TEST(Modes, TheSameTreeGivesTheSameBits) {
  const Analysis first = analyse(fine_crooked_tree(), 12);
  const Analysis second = analyse(fine_crooked_tree(), 12);
  EXPECT_EQ(first.modes.stiffness_per_s2, second.modes.stiffness_per_s2);
  EXPECT_EQ(first.modes.shapes, second.modes.shapes);
}

TEST(Modes, LargestDisplacementIsPositive) {
  const Modes modes = analyse(fine_crooked_tree(), 12).modes;
  for (Eigen::Index i = 0; i < 12; ++i) {
    double largest = 0;
    for (Eigen::Index row = 0; row < modes.shapes.rows(); ++row) {
      if (row % 6 < 3 && std::abs(modes.shapes(row, i)) > std::abs(largest)) largest = modes.shapes(row, i);
    }
    EXPECT_GT(largest, 0) << i;
  }
}

TEST(Modes, DoNotDependOnHowTheTreeIsTurned) {
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(1.1, Eigen::Vector3d(0.3, -0.8, 0.5).normalized()).toRotationMatrix();
  const Modes upright = analyse(fine_crooked_tree(), 15).modes;
  const Modes turned = analyse(testing::turned(fine_crooked_tree(), rotation), 15).modes;
  EXPECT_LT(((upright.stiffness_per_s2 - turned.stiffness_per_s2).array() / upright.stiffness_per_s2.array()).abs().maxCoeff(),
            1e-9);
  for (Eigen::Index i = 0; i < 15; ++i) {
    const Eigen::Vector3d tip = rotation * upright.shapes.col(i).head<3>();
    EXPECT_NEAR(std::abs(tip.dot(turned.shapes.col(i).head<3>())), tip.squaredNorm(), 1e-5 * tip.squaredNorm());
  }
}

TEST(Modes, LeavesAndBallsWeighWhereTheyAre) {
  // A light pole with a heavy load at its tip: w^2 = 3 E I / (L^3 (m + 33/140 of the pole)) within 0.1 % (Rayleigh).
  const TreeModel bare = pole(20);
  const double rod_mass = 1000 * kPi * 4e-4 * 2;
  const Analysis ball = analyse(bare, 1, {.material = {}, .point_masses = {{20, 30}}});
  EXPECT_NEAR(ball.modes.stiffness_per_s2[0], 3 * 1e10 * kPi * 1.6e-7 / 4 / (8 * (30 + 33.0 / 140 * rod_mass)),
              2e-3 * ball.modes.stiffness_per_s2[0]);
  EXPECT_NEAR(ball.structure.wood_mass_kg, rod_mass, 1e-12 * rod_mass);
  EXPECT_NEAR(ball.structure.total_mass_kg(), 30 + rod_mass, 1e-9);

  TreeModel leafy = bare;
  leafy.leaves.push_back(testing::leaf_at(20, {0, 0, 2}, 10, 3));  // an ellipse of 23.56 m2
  const Analysis leaf = analyse(leafy, 1, {.material = {.leaf_mass_per_area_kg_m2 = 30 / (kPi / 4 * 30)}, .point_masses = {}});
  EXPECT_NEAR(leaf.modes.stiffness_per_s2[0], ball.modes.stiffness_per_s2[0], 1e-9 * ball.modes.stiffness_per_s2[0]);
}

// ---- what cannot be done ------------------------------------------------------------------------------------------------

std::string failure(const BeamStructure& structure, const ModeOptions& options) {
  const auto modes = first_modes(structure, options);
  EXPECT_FALSE(modes.has_value());
  return modes ? "" : modes.error().message;
}

TEST(Modes, MoreThanThereAreIsAnError) {
  const auto small = assemble_beams(pole(3), {});
  ASSERT_TRUE(small);
  EXPECT_EQ(analyse(pole(3), 18).modes.stiffness_per_s2.size(), 18);
  EXPECT_THAT(failure(*small, {.mode_count = 19}), ::testing::HasSubstr("at most 18"));
  EXPECT_THAT(failure(*small, {.mode_count = 0}), ::testing::HasSubstr("at least one"));
  const auto large = assemble_beams(pole(40), {});
  ASSERT_TRUE(large);
  EXPECT_THAT(failure(*large, {.mode_count = 240}), ::testing::HasSubstr("at most 239"));
}

TEST(Modes, TooMuchMemoryIsRefusedFirst) {
  const auto structure = assemble_beams(pole(40), {});
  ASSERT_TRUE(structure);
  EXPECT_THAT(failure(*structure, {.mode_count = 100, .memory_limit_bytes = 1e5}), ::testing::HasSubstr("GB"));
}

TEST(Modes, WhatNothingHoldsIsNamed) {
  const auto held = assemble_beams(pole(30), {});
  ASSERT_TRUE(held);
  // Nodes 31 and 32: a piece of wood along x that touches nothing.
  const Eigen::Index size = held->dof_count() + 12;
  BeamStructure loose{.node_count = 33, .stiffness = {size, size}, .mass = {size, size}};
  const auto put = [](Eigen::SparseMatrix<double>& whole, const Eigen::SparseMatrix<double>& tree, const ElementMatrix& piece) {
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < 12; ++i) {
      for (int j = 0; j < 12; ++j) entries.emplace_back((i + 6) % 12, (j + 6) % 12, piece(i, j));
    }
    for (Eigen::Index column = 0; column < tree.outerSize(); ++column) {
      for (Eigen::SparseMatrix<double>::InnerIterator entry(tree, column); entry; ++entry) {
        entries.emplace_back(12 + static_cast<int>(entry.row()), 12 + static_cast<int>(entry.col()), entry.value());
      }
    }
    whole.setFromTriplets(entries.begin(), entries.end());
  };
  put(loose.stiffness, held->stiffness, beam_stiffness(tapered_beam()));
  put(loose.mass, held->mass, beam_mass(tapered_beam()));
  EXPECT_THAT(failure(loose, {.mode_count = 4}), ::testing::HasSubstr("node 31 is not held"));
}

TEST(Assembly, RefusesWhatIsNoTree) {
  const auto message = [](const TreeModel& tree, const BeamOptions& options) {
    const auto structure = assemble_beams(tree, options);
    EXPECT_FALSE(structure.has_value());
    return structure ? std::string() : structure.error().message;
  };
  EXPECT_FALSE(message({.name = "stump", .nodes = {TreeNode{}}}, {}).empty());
  TreeModel flat = pole(4);
  flat.nodes[2].position_m = flat.nodes[1].position_m;
  EXPECT_THAT(message(flat, {}), ::testing::HasSubstr("2"));
  EXPECT_THAT(message(pole(4), {.material = {.young_modulus_pa = 0}}), ::testing::HasSubstr("Young"));
  EXPECT_THAT(message(pole(4), {.material = {.density_kg_m3 = -1}}), ::testing::HasSubstr("density"));
  EXPECT_THAT(message(pole(4), {.material = {.poisson_ratio = -1}}), ::testing::HasSubstr("Poisson"));
  EXPECT_THAT(message(pole(4), {.material = {}, .point_masses = {{5, 1}}}), ::testing::HasSubstr("node 5"));
  EXPECT_THAT(message(pole(4), {.material = {}, .point_masses = {{4, -1}}}), ::testing::HasSubstr("node 4"));
}

}  // namespace
}  // namespace roseau::structure
