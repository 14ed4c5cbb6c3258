#include "structure/mechanics/sway_simulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "tests/unit/structure/mechanics/trees.h"
#include "tests/unit/structure/mechanics/winds.h"

namespace roseau::structure {
namespace {

using testing::crooked_tree;
using testing::pole;
using testing::UniformWind;

constexpr double kTwoPi = 2 * std::numbers::pi;

const UniformWind& gusty_wind() {
  static const UniformWind wind([](double t) {
    return Vec3{4 + 1.5 * std::sin(2.1 * t) + 0.7 * std::sin(5.3 * t + 1), 1 + 0.8 * std::cos(3.3 * t), 0};
  });
  return wind;
}

SwaySimulation simulation_of(const TreeModel& tree, const WindField& wind, const SwayOptions& options,
                             const ModalParameters& parameters = {.alpha_per_s = 0.2, .beta_s = 0.0005},
                             const DragOptions& drag = {}, std::size_t modes = 8) {
  auto model = ModalModel::build(tree, {}, {.mode_count = modes}, parameters);
  EXPECT_TRUE(model.has_value()) << model.error().message;
  auto load = DragLoad::build(tree, *model, drag);
  EXPECT_TRUE(load.has_value()) << load.error().message;
  auto simulation = SwaySimulation::make(std::move(*model), std::move(*load), wind, options);
  EXPECT_TRUE(simulation.has_value()) << simulation.error().message;
  return std::move(*simulation);
}

ModalState run(SwaySimulation simulation, int steps) {
  for (int i = 0; i < steps; ++i) simulation.advance();
  return simulation.state();
}

TEST(SwaySimulation, SteadyWindKeepsItsEquilibrium) {
  const UniformWind wind(Vec3{5, 1, 0});
  SwaySimulation simulation = simulation_of(crooked_tree(), wind, {.step_s = 0.01});
  const ModalState start = simulation.state();
  EXPECT_GT(simulation.model().displacement_m(8, start.q).x, 1e-4);
  for (int i = 0; i < 200; ++i) simulation.advance();
  EXPECT_TRUE(simulation.state().q.isApprox(start.q, 1e-10));
  EXPECT_NEAR(simulation.time_s(), 2, 1e-12);
}

TEST(SwaySimulation, ErrorFallsWithTheSquareOfTheStep) {
  const TreeModel tree = crooked_tree();
  const ModalState truth = run(simulation_of(tree, gusty_wind(), {.step_s = 1.0 / 3200}), 6400);
  const auto error = [&](int per_second) {
    const ModalState state = run(simulation_of(tree, gusty_wind(), {.step_s = 1.0 / per_second}), 2 * per_second);
    return (state.q - truth.q).norm();
  };
  const double coarse = error(100);
  const double fine = error(200);
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.2);
  EXPECT_LT(fine, 1e-3 * truth.q.norm());
}

TEST(SwaySimulation, ThesisSteppingConvergesToTheSameMotion) {
  const TreeModel tree = pole(10);
  const ModalState truth = run(simulation_of(tree, gusty_wind(), {.step_s = 1.0 / 4000}, {}, {}, 2), 4000);
  const auto error = [&](int per_second) {
    SwayOptions options{.step_s = 1.0 / per_second};
    options.stepping = SwayOptions::Stepping::semi_implicit;
    return (run(simulation_of(tree, gusty_wind(), options, {}, {}, 2), per_second).q - truth.q).norm();
  };
  EXPECT_NEAR(std::log2(error(1000) / error(2000)), 1, 0.2);
}

TEST(SwaySimulation, ThesisSteppingBeyondItsLimitIsRefused) {
  const TreeModel tree = pole(10);
  const ModalModel model = *ModalModel::build(tree, {}, {.mode_count = 8});
  const DragLoad load = *DragLoad::build(tree, model, {});
  SwayOptions options{.step_s = 0.05};
  options.stepping = SwayOptions::Stepping::semi_implicit;
  const auto refused = SwaySimulation::make(model, load, gusty_wind(), options);
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message, ::testing::HasSubstr("unstable"));
}

TEST(SwaySimulation, StatesBetweenStepsAreThoseOfShorterSteps) {
  // A wind that is straight in time, no relative velocity: then the force is straight, too, for an exponent of 1.
  const UniformWind wind([](double t) { return Vec3{1 + 3 * t, 0.5 * t, 0}; });
  const DragOptions drag{.wood_vogel_exponent = -1, .foliage_vogel_exponent = -1, .relative_velocity = false};
  SwaySimulation coarse = simulation_of(crooked_tree(), wind, {.step_s = 0.1}, {}, drag);
  SwaySimulation fine = simulation_of(crooked_tree(), wind, {.step_s = 0.0125}, {}, drag);
  for (int step = 0; step < 3; ++step) {
    const ModalState before = coarse.state();
    coarse.advance();
    EXPECT_TRUE(coarse.state_at(coarse.time_s() - 0.1).q.isApprox(before.q, 1e-12));
    for (int part = 1; part <= 8; ++part) {
      fine.advance();
      const ModalState between = coarse.state_at(fine.time_s());
      EXPECT_LT((between.q - fine.state().q).norm(), 1e-11 * fine.state().q.norm());
      EXPECT_LT((between.q_dot - fine.state().q_dot).norm(), 1e-10 * (1e-3 + fine.state().q_dot.norm()));
    }
  }
  EXPECT_EQ(coarse.state_at(coarse.time_s()).q, coarse.state().q);
}

TEST(SwaySimulation, DragBrakesAFreeSwayAsLinearised) {
  // Released in a steady cross wind: decay by structure plus the diagonal of the aerodynamic damping.
  const UniformWind wind(Vec3{0, 8, 0});
  const DragOptions drag{.foliage_coefficient = 0.5};
  TreeModel tree = pole(10);
  tree.leaves.push_back(testing::leaf_at(10, {0, 0, 2}, 0.8, 0.5));
  SwaySimulation simulation = simulation_of(tree, wind, {.step_s = 1.0 / 400, .pulls = {{10, {0.5, 0, 0}, -1, 0, 0.1}}},
                                            {.alpha_per_s = 0.1, .beta_s = 0}, drag, 2);
  const Eigen::MatrixXd aerodynamic = simulation.load().damping_matrix(Vec3{0, 8, 0});
  const double gamma = 0.1 + aerodynamic(0, 0);
  EXPECT_GT(aerodynamic(0, 0), 0.2);
  for (int i = 0; i < 40; ++i) simulation.advance();  // to the release
  const auto envelope = [&] {
    const double q = simulation.state().q[0];
    const double rate = simulation.state().q_dot[0] + gamma / 2 * q;
    const double w2 = simulation.model().stiffness_per_s2()[0] - gamma * gamma / 4;
    return std::sqrt(q * q + rate * rate / w2);
  };
  const double start = envelope();
  for (int i = 0; i < 400; ++i) simulation.advance();
  EXPECT_NEAR(std::log(start / envelope()), gamma / 2, 0.01 * gamma / 2);
}

TEST(SwaySimulation, ProjectionFollowsTheFullIntegration) {
  const TreeModel tree = crooked_tree();
  SwayOptions options{.step_s = 0.005};
  SwaySimulation full = simulation_of(tree, gusty_wind(), options);
  options.load = SwayOptions::Load::projection;
  options.mean_wind_mps = {4, 1, 0};
  SwaySimulation projected = simulation_of(tree, gusty_wind(), options);
  options.mean_wind_mps = {};
  SwaySimulation uncompensated = simulation_of(tree, gusty_wind(), options);
  double difference = 0;
  double without = 0;
  double mean_square = 0;
  for (int i = 0; i < 4000; ++i) {
    full.advance();
    projected.advance();
    uncompensated.advance();
    difference += (projected.state().q - full.state().q).squaredNorm();
    without += (uncompensated.state().q - full.state().q).squaredNorm();
    mean_square += full.state().q.squaredNorm();
  }
  EXPECT_LT(std::sqrt(difference / mean_square), 0.03);
  EXPECT_LT(difference, 0.2 * without);  // the compensation is what brings them together
}

TEST(SwaySimulation, SameInputsSameBits) {
  const ModalState first = run(simulation_of(crooked_tree(), gusty_wind(), {}), 300);
  const ModalState second = run(simulation_of(crooked_tree(), gusty_wind(), {}), 300);
  EXPECT_EQ(first.q, second.q);
  EXPECT_EQ(first.q_dot, second.q_dot);
}

// ---- ropes --------------------------------------------------------------------------------------------------------------

const UniformWind& still_air() {
  static const UniformWind wind(Vec3{});
  return wind;
}

const DragOptions kNoDrag{.wood_coefficient = 0, .foliage_coefficient = 0};

TEST(SwaySimulation, PulledTreeRestsUnderTheRopeAndDecaysFreelyAfterIt) {
  const double release_s = 0.1037;  // within a step
  SwaySimulation simulation =
      simulation_of(pole(10), still_air(), {.step_s = 0.01, .pulls = {{10, {2, 0, 0}, -1, 0.5, release_s}}},
                    {.alpha_per_s = 0.3, .beta_s = 0}, kNoDrag, 1);
  const double held = simulation.state().q[0];
  EXPECT_NEAR(held, simulation.model().static_amplitudes(simulation.model().modal_force_at(10, {2, 0, 0}))[0], 1e-14);
  const double half = 0.15;
  const double w = std::sqrt(simulation.model().stiffness_per_s2()[0] - half * half);
  for (int i = 0; i < 300; ++i) {
    simulation.advance();
    const double t = std::max(0.0, simulation.time_s() - release_s);
    const double truth = held * std::exp(-half * t) * (std::cos(w * t) + half / w * std::sin(w * t));
    ASSERT_NEAR(simulation.state().q[0], truth, 1e-11 * std::abs(held)) << simulation.time_s();
    const double t_mid = std::max(0.0, simulation.time_s() - 0.004 - release_s);
    const double truth_mid = held * std::exp(-half * t_mid) * (std::cos(w * t_mid) + half / w * std::sin(w * t_mid));
    ASSERT_NEAR(simulation.state_at(simulation.time_s() - 0.004).q[0], truth_mid, 1e-11 * std::abs(held));
  }
}

TEST(SwaySimulation, RampDoesNotDependOnWhereTheStepsFall) {
  const std::vector<RopePull> pulls{{8, {1, 2, 0}, 0.033, 0.219, 0.61}};
  const ModalState coarse = run(simulation_of(crooked_tree(), still_air(), {.step_s = 0.1, .pulls = pulls}, {}, kNoDrag), 10);
  const ModalState fine = run(simulation_of(crooked_tree(), still_air(), {.step_s = 0.004, .pulls = pulls}, {}, kNoDrag), 250);
  EXPECT_LT((coarse.q - fine.q).norm(), 1e-11 * fine.q.norm());
}

TEST(SwaySimulation, RopesThatCannotBeAreRefused) {
  const TreeModel tree = pole(10);
  const ModalModel model = *ModalModel::build(tree, {}, {.mode_count = 2});
  const DragLoad load = *DragLoad::build(tree, model, {});
  const auto message = [&](const RopePull& pull) {
    const auto made = SwaySimulation::make(model, load, still_air(), {.pulls = {pull}});
    return made ? std::string() : made.error().message;
  };
  EXPECT_THAT(message({11, {1, 0, 0}, 0, 0, 1}), ::testing::HasSubstr("node 11"));
  EXPECT_THAT(message({10, {1, 0, 0}, 0, 2, 1}), ::testing::HasSubstr("release"));
  EXPECT_FALSE(SwaySimulation::make(model, load, still_air(), {.step_s = 0}).has_value());
}

TEST(SwaySimulation, ParametersChangeOnTheRun) {
  SwaySimulation simulation = simulation_of(pole(10), still_air(), {.step_s = 0.01}, {}, kNoDrag, 2);
  const double before = simulation.model().natural_frequency_hz(0);
  simulation.advance();
  ASSERT_TRUE(simulation.set_parameters({.mass_factor = 4}));
  EXPECT_NEAR(simulation.model().natural_frequency_hz(0), before / 2, 1e-12);
  EXPECT_FALSE(simulation.set_parameters({.mass_factor = 0}));
  simulation.advance();
}

}  // namespace
}  // namespace roseau::structure
