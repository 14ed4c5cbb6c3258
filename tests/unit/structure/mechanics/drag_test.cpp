#include "structure/mechanics/drag_load.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <functional>

#include "structure/mechanics/beam_element.h"
#include "structure/mechanics/wind_projection.h"
#include "tests/unit/structure/mechanics/trees.h"
#include "tests/unit/structure/mechanics/winds.h"

namespace roseau::structure {
namespace {

using testing::crooked_tree;
using testing::pole;
using testing::UniformWind;

ModalModel model_of(const TreeModel& tree, std::size_t modes) {
  auto model = ModalModel::build(tree, {}, {.mode_count = modes});
  EXPECT_TRUE(model.has_value()) << model.error().message;
  return std::move(*model);
}

DragLoad load_of(const TreeModel& tree, const ModalModel& model, const DragOptions& options = {}) {
  auto load = DragLoad::build(tree, model, options);
  EXPECT_TRUE(load.has_value()) << load.error().message;
  return std::move(*load);
}

Eigen::VectorXd uniform_force(DragLoad& load, const Vec3& air, const Eigen::VectorXd& q_dot) {
  Eigen::VectorXd force;
  load.modal_force(std::vector<Vec3>(load.points_in_world().size(), air), q_dot, force);
  return force;
}

/// The integral 6.25 once more, by brute force: the midpoint rule with many points, in the wind and motion given.
Eigen::VectorXd brute_force(const TreeModel& tree, const ModalModel& model, const std::function<Vec3(const Vec3&)>& wind,
                            const Eigen::VectorXd& q_dot, double wood_exponent, double foliage_exponent, double speed_mps) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(model.mode_count()));
  const auto add = [&](const Vec3& position, double scale, double exponent, const Eigen::MatrixXd& shape) {
    const Vec3 air = wind(position);
    const Eigen::Vector3d relative = Eigen::Vector3d(air.x, air.y, air.z) - shape * q_dot;
    const double v = relative.norm();
    force += shape.transpose() * (scale * std::pow(speed_mps, 2 - exponent) * std::pow(v, exponent - 1) * relative);
  };
  constexpr int kParts = 2000;
  for (std::size_t i = 1; i < tree.nodes.size(); ++i) {
    const auto& node = tree.nodes[i];
    const auto parent = static_cast<std::size_t>(node.parent);
    const Vec3 start = tree.nodes[parent].position_m;
    const Eigen::Vector3d along(node.position_m.x - start.x, node.position_m.y - start.y, node.position_m.z - start.z);
    const double length = along.norm();
    const Eigen::Matrix3d axes = beam_axes(along);
    Eigen::MatrixXd ends(12, force.size());
    for (Eigen::Index block = 0; block < 4; ++block) {
      const auto& rows = block % 2 == 0 ? model.translations() : model.rotations();
      ends.middleRows(3 * block, 3) =
          axes.transpose() * rows.middleRows(static_cast<Eigen::Index>(3 * (block < 2 ? parent : i)), 3);
    }
    for (int part = 0; part < kParts; ++part) {
      const double x = (part + 0.5) / kParts;
      const double diameter = 2 * (node.start_radius_m + x * (node.end_radius_m - node.start_radius_m));
      const Vec3 position{start.x + x * along.x(), start.y + x * along.y(), start.z + x * along.z()};
      add(position, 0.5 * 1.2 * 1.0 * diameter * length / kParts, wood_exponent,
          axes * beam_shape(length, x).topRows<3>() * ends);
    }
  }
  for (const Leaf& leaf : tree.leaves) {
    const double area = std::numbers::pi / 4 * leaf.length_m * leaf.width_m;
    add(tree.nodes[leaf.node].position_m, 0.5 * 1.2 * 0.5 * area, foliage_exponent,
        model.translations().middleRows(3 * static_cast<Eigen::Index>(leaf.node), 3));
  }
  return force;
}

TEST(DragLoad, UniformWindIsIntegratedExactly) {
  const TreeModel tree = crooked_tree();
  const ModalModel model = model_of(tree, 10);
  DragLoad load = load_of(tree, model);
  const Vec3 air{4, -2.5, 0.7};
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(10);
  const Eigen::VectorXd truth = brute_force(
      tree, model, [&](const Vec3&) { return air; }, still, 2, 2, 5);
  EXPECT_LT((uniform_force(load, air, still) - truth).norm(), 1e-6 * truth.norm());  // the midpoint rule's own error
}

TEST(DragLoad, ForceOnAPoleIsItsDiameterTimesTheSquareOfTheSpeed) {
  // Only one mode, and its force known: 1/2 rho C D V^2 times the integral of the shape.
  const TreeModel tree = pole(1, 2, 0.02);
  const ModalModel model = model_of(tree, 1);
  DragLoad load = load_of(tree, model, {.wood_coefficient = 0.8});
  const double u = model.translation(1, 0).x();
  const double turn = model.rotations()(3 + 1, 0);
  const double shape_integral = u * 2 / 2 - turn * 4 / 12;  // of h3 and h4
  const double force = uniform_force(load, {3, 0, 0}, Eigen::VectorXd::Zero(1))[0];
  EXPECT_NEAR(force, 0.5 * 1.2 * 0.8 * 0.04 * 9 * shape_integral, 1e-12);
}

TEST(DragLoad, RelativeVelocityShearAndStreamlining) {
  const TreeModel tree = crooked_tree();
  const ModalModel model = model_of(tree, 10);
  const auto shear = [](const Vec3& p) { return Vec3{2 + 1.5 * p.z, -1 + 0.3 * p.x, 0.2 * p.y}; };
  const Eigen::VectorXd q_dot = Eigen::VectorXd::LinSpaced(10, -0.4, 0.5);
  for (const double exponent : {2.0, 1.4, 1.0, 0.5}) {
    DragLoad load = load_of(tree, model, {.foliage_vogel_exponent = exponent - 2, .reference_speed_mps = 4});
    std::vector<Vec3> air;
    for (const Vec3& point : load.points_in_world()) air.push_back(shear(point));
    Eigen::VectorXd force;
    load.modal_force(air, q_dot, force);
    const Eigen::VectorXd truth = brute_force(tree, model, shear, q_dot, 2, exponent, 4);
    EXPECT_LT((force - truth).norm(), 2e-4 * truth.norm()) << exponent;  // two points see a wind that changes along a segment
  }
}

TEST(DragLoad, LawsAgreeAtTheReferenceSpeed) {
  const TreeModel tree = crooked_tree();
  const ModalModel model = model_of(tree, 5);
  DragLoad rigid = load_of(tree, model, {.reference_speed_mps = 6});
  DragLoad soft = load_of(tree, model, {.wood_vogel_exponent = -0.3, .foliage_vogel_exponent = -0.8, .reference_speed_mps = 6});
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(5);
  EXPECT_TRUE(uniform_force(rigid, {0, 6, 0}, still).isApprox(uniform_force(soft, {0, 6, 0}, still), 1e-12));
  EXPECT_GT(uniform_force(rigid, {0, 9, 0}, still).norm(), uniform_force(soft, {0, 9, 0}, still).norm());
  EXPECT_LT(uniform_force(rigid, {0, 3, 0}, still).norm(), uniform_force(soft, {0, 3, 0}, still).norm());
}

TEST(DragLoad, StillAirAndStillTreeGiveNoForceForAnyLaw) {
  const TreeModel tree = crooked_tree();
  const ModalModel model = model_of(tree, 5);
  for (const double vogel : {0.0, -0.7, -1.0, -1.8}) {
    DragLoad load = load_of(tree, model, {.wood_vogel_exponent = vogel, .foliage_vogel_exponent = vogel});
    const Eigen::VectorXd force = uniform_force(load, {}, Eigen::VectorXd::Zero(5));
    EXPECT_EQ(force.norm(), 0) << vogel;
  }
}

TEST(DragLoad, DampingMatrixIsTheSlopeOfTheForce) {
  const TreeModel tree = crooked_tree();
  const ModalModel model = model_of(tree, 6);
  DragLoad load = load_of(tree, model, {.foliage_vogel_exponent = -0.6});
  const Vec3 air{5, 1, -0.5};
  const Eigen::MatrixXd damping = load.damping_matrix(air);
  const double step = 1e-5;
  for (Eigen::Index mode = 0; mode < 6; ++mode) {
    const Eigen::VectorXd nudge = step * Eigen::VectorXd::Unit(6, mode);
    const Eigen::VectorXd slope = (uniform_force(load, air, -nudge) - uniform_force(load, air, nudge)) / (2 * step);
    EXPECT_LT((damping.col(mode) - slope).norm(), 1e-7 * slope.norm()) << mode;
  }
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(damping).eigenvalues().minCoeff(), 0);
  DragLoad fixed = load_of(tree, model, {.relative_velocity = false});
  EXPECT_EQ(fixed.damping_matrix(air).norm(), 0);
}

TEST(DragLoad, StandsWhereItIsPut) {
  const TreeModel tree = crooked_tree();
  const ModalModel model = model_of(tree, 3);
  const DragLoad here = load_of(tree, model);
  const DragLoad there = load_of(tree, model, {.foot_in_world_m = {10, -20, 1}});
  ASSERT_EQ(here.points_in_world().size(), there.points_in_world().size());
  EXPECT_EQ(here.wood_point_count(), 2 * tree.segment_count());
  EXPECT_EQ(here.points_in_world().size() - here.wood_point_count(), 4U);  // nodes with leaves
  EXPECT_NEAR(there.points_in_world()[7].y, here.points_in_world()[7].y - 20, 1e-12);
}

TEST(DragLoad, RefusesWhatMakesNoSense) {
  const TreeModel tree = crooked_tree();
  const ModalModel model = model_of(tree, 3);
  const auto message = [&](const DragOptions& options) {
    const auto load = DragLoad::build(tree, model, options);
    return load ? std::string() : load.error().message;
  };
  EXPECT_THAT(message({.wood_vogel_exponent = -2}), ::testing::HasSubstr("Vogel"));
  EXPECT_THAT(message({.foliage_vogel_exponent = 0.1}), ::testing::HasSubstr("Vogel"));
  EXPECT_THAT(message({.wood_coefficient = -1}), ::testing::HasSubstr("coefficient"));
  EXPECT_THAT(message({.reference_speed_mps = 0}), ::testing::HasSubstr("reference speed"));
  EXPECT_THAT(message({.air_density_kg_m3 = std::nan("")}), ::testing::HasSubstr("density"));
}

// ---- the projection -----------------------------------------------------------------------------------------------------

TEST(WindProjection, EqualsTheFullIntegrationInUniformWindWithoutMotion) {
  const TreeModel tree = crooked_tree();
  const ModalModel model = model_of(tree, 12);
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(12);
  for (const double vogel : {0.0, -0.6, -1.0}) {
    DragLoad load = load_of(tree, model, {.foliage_vogel_exponent = vogel});
    const WindProjection projection(load);
    for (const Vec3& air : {Vec3{4, 0, 0}, Vec3{-1, 7, 0.5}, Vec3{0.01, 0, -0.02}}) {
      const Eigen::VectorXd full = uniform_force(load, air, still);
      Eigen::VectorXd projected;
      projection.modal_force(air, projected);
      EXPECT_LT((projected - full).norm(), 1e-12 * full.norm()) << vogel;
    }
  }
}

TEST(WindProjection, DampingIsTheDiagonalOfTheFullOne) {
  const TreeModel tree = crooked_tree();
  const ModalModel model = model_of(tree, 8);
  DragLoad load = load_of(tree, model, {.foliage_vogel_exponent = -0.4});
  const Vec3 air{3, 2, 0};
  const Eigen::ArrayXd truth = load.damping_matrix(air).diagonal().array();
  EXPECT_LT(((WindProjection(load).damping(air) - truth) / truth).abs().maxCoeff(), 1e-12);
}

TEST(WindProjection, DifferenceToTheFullIntegrationIsReported) {
  const TreeModel tree = crooked_tree();
  const ModalModel model = model_of(tree, 6);
  DragLoad load = load_of(tree, model);
  const std::vector<double> times_s{0, 0.5, 1, 1.5, 2};
  const ProjectionError none = compare_projection(load, UniformWind([](double t) {
                                                    return Vec3{3 + std::sin(t), 1, 0};
                                                  }),
                                                  times_s);
  EXPECT_LT(none.relative_rms, 1e-12);
  const testing::ShearedWind sheared(2, 1.2);
  const ProjectionError some = compare_projection(load, sheared, times_s);
  EXPECT_GT(some.relative_rms, 0.01);
  EXPECT_LT(some.relative_rms, 0.5);
  EXPECT_NEAR(std::sqrt(some.rms.square().sum() / some.reference_rms.square().sum()), some.relative_rms, 1e-12);
}

}  // namespace
}  // namespace roseau::structure
