#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numbers>

#include "structure/mechanics/drag_load.h"
#include "structure/mechanics/static_pull.h"
#include "structure/mechanics/sway_simulation.h"
#include "structure/mechanics/sway_truth.h"
#include "tests/unit/structure/mechanics/trees.h"
#include "tests/unit/structure/mechanics/winds.h"

namespace roseau::structure {
namespace {

using testing::crooked_tree;
using testing::pole;

constexpr double kTwoPi = 2 * std::numbers::pi;

struct Plant {
  BeamStructure structure;
  ModalModel model;
};

Plant plant_of(const TreeModel& tree, std::size_t mode_count, const ModalParameters& parameters = {}) {
  auto structure = assemble_beams(tree, {});
  EXPECT_TRUE(structure.has_value());
  const auto modes = first_modes(*structure, {.mode_count = mode_count});
  EXPECT_TRUE(modes.has_value());
  ModalModel model(*structure, *modes);
  EXPECT_TRUE(model.set_parameters(parameters));
  return {std::move(*structure), std::move(model)};
}

// ---- ropes --------------------------------------------------------------------------------------------------------------

TEST(StaticPull, BendsAPoleByTheTextbookAmount) {
  const Plant plant = plant_of(pole(20), 6);
  const auto pull = static_pull(plant.structure, plant.model, 20, {0, 30, 0});
  ASSERT_TRUE(pull.has_value());
  const double truth = 30 * 8 / (3 * 1e10 * std::numbers::pi * 1.6e-7 / 4);
  EXPECT_NEAR(pull->displacement_m.y, truth, 1e-9 * truth);
  // The first mode of a cantilever has 97.07 % of the tip's flexibility: 4 / 1.8751^4 of L^3 / E I, against 1 / 3.
  const double first = 12 / std::pow(1.8751040687119611, 4);
  const double second = 12 / std::pow(4.6940911329741746, 4);
  const double third = 12 / std::pow(7.8547574382376126, 4);
  EXPECT_NEAR(pull->truncation_error, 1 - first - second - third, 1e-4);
  EXPECT_NEAR(pull->energy_share, first + second + third, 1e-4);
}

TEST(StaticPull, TruncationVanishesWithAllModes) {
  const Plant plant = plant_of(crooked_tree(), 90);
  const auto pull = static_pull(plant.structure, plant.model, 8, {3, -1, 2});
  ASSERT_TRUE(pull.has_value());
  EXPECT_LT(pull->truncation_error, 1e-7);
  EXPECT_NEAR(pull->energy_share, 1, 1e-7);
}

TEST(StaticPull, WantedDisplacementIsReachedWithTheParametersInForce) {
  const Plant plant = plant_of(crooked_tree(), 12, {.young_modulus_scale = 0.5, .mass_factor = 2});
  const auto pull = static_pull_by(plant.structure, plant.model, 8, {0, -4, 3}, 0.3);
  ASSERT_TRUE(pull.has_value());
  EXPECT_NEAR(pull->displacement_m.y * -0.8 + pull->displacement_m.z * 0.6, 0.3, 1e-12);
  EXPECT_NEAR(pull->force_n.y / pull->force_n.z, -4.0 / 3, 1e-12);
  const auto stiff =
      static_pull_by(plant_of(crooked_tree(), 12).structure, plant_of(crooked_tree(), 12).model, 8, {0, -4, 3}, 0.3);
  ASSERT_TRUE(stiff.has_value());
  EXPECT_NEAR(pull->force_n.z, 0.5 * stiff->force_n.z, 1e-9 * pull->force_n.z);
  EXPECT_NEAR(pull->amplitudes[0], stiff->amplitudes[0], 1e-9 * std::abs(stiff->amplitudes[0]));
}

TEST(StaticPull, RefusesWhatCannotBePulled) {
  const Plant plant = plant_of(pole(5), 2);
  EXPECT_FALSE(static_pull(plant.structure, plant.model, 0, {1, 0, 0}));
  EXPECT_FALSE(static_pull(plant.structure, plant.model, 6, {1, 0, 0}));
  EXPECT_FALSE(static_pull(plant.structure, plant.model, 5, {0, 0, 0}));
  EXPECT_FALSE(static_pull_by(plant.structure, plant.model, 5, {1, 0, 0}, -1));
}

// ---- what an identifier should find -------------------------------------------------------------------------------------

TEST(DominantMode, OfAPoleIsTheOneInThePulledDirection) {
  const Plant plant = plant_of(pole(40), 8);
  const DominantMode x = dominant_mode(plant.model, 40, {1, 0, 0}, plant.model.modal_force_at(40, {1, 0, 0}));
  const DominantMode y = dominant_mode(plant.model, 40, {0, 2, 0}, plant.model.modal_force_at(40, {0, 1, 0}));
  EXPECT_EQ(x.mode, 0U);
  EXPECT_EQ(y.mode, 1U);
  EXPECT_NEAR(x.share, 0.9707, 0.003);  // see StaticPull.BendsAPoleByTheTextbookAmount; of four modes in x
}

TEST(DominantMode, OfABranchMayBeItsOwn) {
  // A stout trunk with one whip: its tip moves with the whip's own mode, the trunk's top with the trunk's.
  TreeModel tree = pole(5, 2, 0.05);
  const std::size_t tip = testing::add_branch(tree, 3, {1.2, 0, 0.3}, 0.008, 0.003, 6);
  const Plant plant = plant_of(tree, 12);
  const auto of_tip = dominant_mode(plant.model, tip, {0, 1, 0}, plant.model.modal_force_at(tip, {0, 1, 0}));
  const auto of_top = dominant_mode(plant.model, 5, {0, 1, 0}, plant.model.modal_force_at(5, {0, 1, 0}));
  EXPECT_NE(of_tip.mode, of_top.mode);
  EXPECT_GT(plant.model.natural_frequency_hz(of_top.mode), plant.model.natural_frequency_hz(of_tip.mode));
}

TEST(LinearisedModes, WithoutAirAreTheStructures) {
  const Plant plant = plant_of(crooked_tree(), 8, {.alpha_per_s = 0.3, .beta_s = 0.002});
  const auto modes = linearised_modes(plant.model, Eigen::MatrixXd::Zero(8, 8));
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(modes[i].natural_frequency_hz, plant.model.natural_frequency_hz(i), 1e-9);
    EXPECT_NEAR(modes[i].damping_ratio, plant.model.damping_ratio(i), 1e-9);
  }
}

TEST(LinearisedModes, DiagonalAirAddsToEachMode) {
  const Plant plant = plant_of(crooked_tree(), 6, {.mass_factor = 2, .alpha_per_s = 0.3, .beta_s = 0});
  const Eigen::VectorXd air = Eigen::VectorXd::LinSpaced(6, 0.2, 400);  // the last ones beyond critical
  const auto modes = linearised_modes(plant.model, air.asDiagonal());
  for (std::size_t i = 0; i < 6; ++i) {
    const double w = kTwoPi * plant.model.natural_frequency_hz(i);
    EXPECT_NEAR(modes[i].natural_frequency_hz * kTwoPi, w, 1e-8 * w) << i;
    const double gamma = 0.3 + air[static_cast<Eigen::Index>(i)] / 2;
    EXPECT_NEAR(modes[i].damping_ratio, gamma / (2 * w), 1e-8 * gamma / (2 * w)) << i;
  }
  EXPECT_GT(modes[5].damping_ratio, 1);
}

TEST(LinearisedModes, AreWhatAFreeDecayInTheWindShows) {
  // Pulled out of its equilibrium in a steady wind by a little, let go: logarithmic decrement over some periods.
  TreeModel tree = pole(10);
  tree.leaves.push_back(testing::leaf_at(10, {0, 0, 2}, 0.6, 0.4));
  const Plant plant = plant_of(tree, 6, {.alpha_per_s = 0.2, .beta_s = 0.0005});
  const testing::UniformWind wind(Vec3{6, 0, 0});
  const DragLoad load = *DragLoad::build(tree, plant.model, {});
  const LinearisedMode truth = linearised_modes(plant.model, load.damping_matrix(Vec3{6, 0, 0}))[0];
  EXPECT_GT(truth.damping_ratio, 1.5 * plant.model.damping_ratio(0));
  auto simulation =
      SwaySimulation::make(plant.model, load, wind, {.step_s = 0.002, .pulls = {{10, {0.05, 0, 0}, -1, 0, 0.001}}});
  ASSERT_TRUE(simulation.has_value());
  const double rest = plant.model.displacement_m(10, plant.model.static_amplitudes(simulation->wind_force())).x;
  std::vector<double> crossings_s;
  std::vector<double> peaks;
  double before = 0;
  double peak = 0;
  for (int i = 0; i < 3000; ++i) {
    simulation->advance();
    const double x = plant.model.displacement_m(10, simulation->state().q).x - rest;
    peak = std::max(peak, std::abs(x));
    if (before > 0 && x <= 0) {
      crossings_s.push_back(simulation->time_s() - 0.002 * x / (x - before));
      peaks.push_back(peak);
      peak = 0;
    }
    before = x;
  }
  ASSERT_GT(crossings_s.size(), 8U);
  const double period_s = (crossings_s[8] - crossings_s[2]) / 6;
  const double decrement = std::log(peaks[2] / peaks[8]) / 6;
  const double ratio = decrement / std::hypot(decrement, kTwoPi);
  EXPECT_NEAR(ratio, truth.damping_ratio, 0.03 * truth.damping_ratio);
  EXPECT_NEAR(1 / (period_s * std::sqrt(1 - ratio * ratio)), truth.natural_frequency_hz, 0.005 * truth.natural_frequency_hz);
}

TEST(EquivalentStaticDisplacement, OfASteadyForceIsWhereThePointComesToRest) {
  const Plant plant = plant_of(crooked_tree(), 10);
  const Eigen::VectorXd force = plant.model.modal_force_at(5, {1, 2, 3});
  const Vec3 still = equivalent_static_displacement_m(plant.model, 8, force);
  ModalState state = ModalState::at_rest(10);
  const ExactStepper stepper(plant.model, 5);
  for (int i = 0; i < 200; ++i) stepper.advance(state, force, force, state);
  EXPECT_NEAR(plant.model.displacement_m(8, state.q).x, still.x, 1e-10);
  EXPECT_NEAR(plant.model.displacement_m(8, state.q).y, still.y, 1e-10);
}

}  // namespace
}  // namespace roseau::structure
