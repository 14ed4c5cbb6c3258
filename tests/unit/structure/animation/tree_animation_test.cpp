#include "structure/animation/tree_animation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "structure/animation/forest.h"
#include "structure/mechanics/modal_stepper.h"
#include "structure/mechanics/wind_projection.h"
#include "structure/tree/cantilever.h"
#include "structure/tree/grown_tree.h"

namespace roseau::structure {
namespace {

constexpr Vec3 kWind{4, -2, 0.5};

TreeModel small_tree() {
  auto tree =
      grow_tree({.height_m = 3, .trunk_radius_m = 0.03, .main_branch_count = 6, .branching_orders = 2, .leaf_count = 50});
  EXPECT_TRUE(tree) << tree.error().message;
  return std::move(*tree);
}

ModalModel modes_of(const TreeModel& tree) {
  ModalParameters parameters;
  parameters.mass_factor = 1.5;
  auto model = ModalModel::build(tree, {}, {.mode_count = 8}, parameters);
  EXPECT_TRUE(model) << model.error().message;
  return std::move(*model);
}

DragLoad load_on(const TreeModel& tree, const ModalModel& model, const DragOptions& options = {}) {
  auto load = DragLoad::build(tree, model, options);
  EXPECT_TRUE(load) << load.error().message;
  return std::move(*load);
}

// The same tree, wind and frames through mechanics' stepper in double precision.
TEST(TreeAnimation, ForestMovesAsTheMechanicsDo) {
  const TreeModel tree = small_tree();
  const ModalModel model = modes_of(tree);
  const DragLoad load = load_on(tree, model);
  const WindProjection projection(load);
  const auto basis = modal_basis(model, load, kWind);
  ASSERT_TRUE(basis) << basis.error().message;
  auto forest = Forest::make(*basis, std::vector<TreeInstance>(1));
  ASSERT_TRUE(forest) << forest.error().message;

  const double step_s = 1.0 / 30;
  const ExactStepper stepper(model, step_s, projection.damping(kWind));
  ModalState state = ModalState::at_rest(8);
  Eigen::VectorXd begin = Eigen::VectorXd::Zero(8);
  Eigen::VectorXd end;
  for (int frame = 0; frame < 300; ++frame) {
    const double gust = 1 + 0.5 * std::sin(0.3 * frame);
    const std::vector<Vec3> winds{{kWind.x * gust, kWind.y, kWind.z}};
    projection.modal_force(winds[0], end);
    stepper.advance(state, begin, end, state);
    begin = end;
    forest->advance(step_s, winds);
  }
  double largest_m = 0;
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    const Vec3 expected = model.displacement_m(n, state.q);
    const auto row = forest->displacements_m(0);
    EXPECT_NEAR(row[3 * n], expected.x, 1e-5) << n;
    EXPECT_NEAR(row[3 * n + 1], expected.y, 1e-5) << n;
    EXPECT_NEAR(row[3 * n + 2], expected.z, 1e-5) << n;
    largest_m = std::max(largest_m, std::abs(expected.x));
  }
  EXPECT_GT(largest_m, 0.01);
}

TEST(TreeAnimation, YieldingLeavesPushAsTheSquareLawAtTheMeanWind) {
  const TreeModel tree = small_tree();
  const ModalModel model = modes_of(tree);
  const DragLoad load = load_on(tree, model, {.foliage_vogel_exponent = -0.7});
  const auto basis = modal_basis(model, load, kWind);
  ASSERT_TRUE(basis);
  Eigen::VectorXd force;
  WindProjection(load).modal_force(kWind, force);
  const Eigen::Vector3d wind(kWind.x, kWind.y, kWind.z);
  const Eigen::VectorXd square = basis->wind_projection.transpose() * (wind.norm() * wind);
  EXPECT_LT((square * model.modal_mass() - force).norm(), 1e-12 * force.norm());
  EXPECT_THAT(modal_basis(model, load, {}).error().message, testing::HasSubstr("Vogel exponent"));
}

// A whole tree, not a pole: what docs/animation.md says of its lengths.
TEST(TreeAnimation, CorrectionKeepsTheLengthsOfATreesBranches) {
  const TreeModel tree = small_tree();
  const ModalModel model = modes_of(tree);
  const Skeleton bones = skeleton(tree);
  ASSERT_EQ(bones.parents.size(), tree.nodes.size());
  std::vector<double> range;
  for (Eigen::Index i = 0; i < 8; ++i) range.push_back(amplitude_for(model.translations().col(i), 0.45));
  const auto correction = fit_correction(bones, model.translations(), range);
  ASSERT_TRUE(correction);
  for (Eigen::Index i = 0; i < 8; ++i) {
    Eigen::VectorXd q = Eigen::VectorXd::Zero(8);
    q[i] = 0.75 * range[static_cast<std::size_t>(i)];
    const double linear = length_error(bones, model.translations() * q).rms;
    const double corrected = length_error(bones, correction->displacement_m(q)).rms;
    EXPECT_LT(corrected, linear / 20) << i << ": " << linear;
  }
}

}  // namespace
}  // namespace roseau::structure
