#include "structure/mechanics/modal_stepper.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <complex>
#include <numbers>

#include "structure/mechanics/oscillator_step.h"
#include "tests/unit/structure/mechanics/trees.h"

namespace roseau::structure {
namespace {

using testing::crooked_tree;
using testing::pole;

constexpr double kTwoPi = 2 * std::numbers::pi;

/// Exponential of the oscillator's matrix in 60 digits (mpmath), rounded to double.
struct GoldenStep {
  double stiffness_per_s2;
  double damping_per_s;
  double step_s;
  double coefficients[8];  // x: by x, x', force at the beginning, at the end; then x' likewise
};

constexpr GoldenStep kGolden[] = {
    {39.478,
     0.5,
     0.008,
     {0.9987386522502347, 0.007980659676886551, 2.129598683501531e-05, 1.0654662888001128e-05, -0.3150604827241273,
      0.9947483224117915, 0.003986828461509497, 0.0039938312153770545}},
    {39.478,
     0.0,
     0.25,
     {8.307996688317792e-06, 0.159155784866913, 0.016125812641748918, 0.00920454077036192, -6.283152074975993,
      8.307996688317792e-06, 0.05783437121846967, 0.10132141364844335}},
    {1e-09,
     0.0,
     0.01,
     {0.99999999999995, 0.009999999999999834, 3.3333333333333e-05, 1.6666666666666583e-05, -9.999999999999835e-12,
      0.99999999999995, 0.004999999999999875, 0.0049999999999999585}},
    {0.0, 0.0, 0.1, {1.0, 0.1, 0.0033333333333333335, 0.0016666666666666668, 0.0, 1.0, 0.05, 0.05}},
    {0.0,
     3.0,
     0.1,
     {1.0, 0.08639392643942738, 0.002986550698604899, 0.001548807154919309, 0.0, 0.7408182206817179, 0.04104034790418531,
      0.04535357853524208}},
    {0.0, 5000.0, 0.5, {1.0, 0.0002, 4.9999984e-05, 4.9960016e-05, 0.0, 0.0, 8e-08, 0.00019992}},
    {100.0,
     20.0,
     0.05,
     {0.9097959895689501, 0.030326532985631673, 0.0005755071186788276, 0.0003265329856316712, -3.0326532985631673,
      0.3032653298563167, 0.012285730899421698, 0.018040802086209975}},
    {100.0,
     20.000001,
     0.05,
     {0.9097959908325557, 0.03032653235382891, 0.0005755071095460173, 0.00032653298212842615, -3.032653235382891,
      0.30326531342944507, 0.012285730520340042, 0.018040801833488867}},
    {100.0,
     19.9,
     0.2,
     {0.40419595034730993, 0.02715764252969444, 0.0032441729170558887, 0.0027138675794710124, -2.715764252969444,
      -0.13624113599360943, -0.0026325599529400615, 0.029790202482634504}},
    {4000000.0,
     40.0,
     0.01,
     {0.3423282338401336, 0.0003735796100820604, -7.607815026644193e-08, 2.4049609180640853e-07, -1494.3184403282416,
      0.3273850494368512, 0.00035713781592806377, 1.6441794153996657e-05}},
    {25.0,
     300.0,
     0.1,
     {0.9919746974764513, 0.0033075013306411295, 0.00016546474623221685, 0.00015554735470973163, -0.08268753326602823,
      -0.00027570171588750346, 9.738032122164457e-05, 0.0032101210094194845}},
    {1e-06,
     30.0,
     0.1,
     {0.9999999977224588, 0.031673764341481, 0.0013700549149666614, 0.0009074862706256844, -3.1673764341481e-08,
      0.04978706747802868, 0.008898352485557547, 0.022775411855923456}},
    {100000000.0,
     3.0,
     0.01,
     {0.8494052314848918, -4.988278001391775e-05, -8.543930577019779e-09, 1.0049878262170862e-08, 4988.2780013917745,
      0.8495548798249335, -5.003337478243286e-05, 1.5059476851510828e-07}},
    {2.0,
     1e-09,
     1.0,
     {0.15594369503663064, 0.6984559982873804, 0.27125615183638896, 0.15077200064529575, -1.3969119965747607,
      0.15594369433817462, 0.2764278458056957, 0.4220281524816847}},
    {2.2,
     1.9,
     1.0,
     {0.45477550745868045, 0.30836932218561475, 0.14748614219581868, 0.10034317259569019, -0.6784125088083525,
      -0.13112620469398753, 0.06054000739410589, 0.24782931479150885}},
    {0.8,
     2.05,
     1.0,
     {0.7880270127955207, 0.3739726260694519, 0.1614079912317617, 0.10355824277383743, -0.29917810085556157,
      0.021383129353144348, 0.10900639206385279, 0.2649662340055991}},
    {10000.0,
     250.0,
     0.03,
     {0.296680629472351, 0.0014710093864784232, 3.38452492183304e-05, 3.6486687834434506e-05, -14.710093864784232,
      -0.0710717171472548, -0.0008733885152804069, 0.00234439790175883}},
    {36.0,
     12.0,
     3.0,
     {2.8936961514953994e-07, 4.5689939234137884e-08, 0.003086411244980451, 0.02469135849475246, -1.6448378124289638e-06,
      -2.589096556601147e-07, -0.009259210889971737, 0.00925925657991097}},
    {0.001,
     0.01,
     0.001,
     {0.9999999995000016, 0.000999994999850001, 3.333320833033335e-07, 1.6666624999250002e-07, -9.999949998500009e-07,
      0.9999899995500031, 0.0004999966665541673, 0.0004999983332958335}},
};

TEST(OscillatorStep, AgreesWithSixtyDigits) {
  for (const GoldenStep& golden : kGolden) {
    const ExactOscillatorStep step = exact_oscillator_step(golden.stiffness_per_s2, golden.damping_per_s, golden.step_s);
    const double found[] = {step.position.position, step.position.velocity, step.position.begin_force, step.position.end_force,
                            step.velocity.position, step.velocity.velocity, step.velocity.begin_force, step.velocity.end_force};
    for (int i = 0; i < 8; ++i) {
      const double crossing = i == 0 || i == 5 ? 1e-15 : 0;  // a cosine near its zero
      EXPECT_NEAR(found[i], golden.coefficients[i], 2e-13 * std::abs(golden.coefficients[i]) + crossing)
          << "w^2 " << golden.stiffness_per_s2 << " gamma " << golden.damping_per_s << " step " << golden.step_s
          << " coefficient " << i;
    }
  }
}

TEST(OscillatorStep, OneLongStepEqualsManyShortOnes) {
  // Composition holds only if position, velocity and force terms all fit together.
  for (const double damping : {0.0, 0.3, 12.0, 80.0}) {
    const ExactOscillatorStep whole = exact_oscillator_step(36, damping, 0.7);
    const ExactOscillatorStep part = exact_oscillator_step(36, damping, 0.07);
    double x = 0.4;
    double v = -1.1;
    const double expected_x = whole.position.position * x + whole.position.velocity * v + whole.position.begin_force * 2 +
                              whole.position.end_force * -3;
    for (int i = 0; i < 10; ++i) {
      const double begin = 2 - 5 * i / 10.0;
      const double end = 2 - 5 * (i + 1) / 10.0;
      const double next = part.position.position * x + part.position.velocity * v + part.position.begin_force * begin +
                          part.position.end_force * end;
      v = part.velocity.position * x + part.velocity.velocity * v + part.velocity.begin_force * begin +
          part.velocity.end_force * end;
      x = next;
    }
    EXPECT_NEAR(x, expected_x, 1e-13) << damping;
  }
}

ModalModel undamped(const TreeModel& tree, std::size_t modes) {
  auto model = ModalModel::build(tree, {}, {.mode_count = modes}, {.alpha_per_s = 0, .beta_s = 0});
  EXPECT_TRUE(model.has_value()) << model.error().message;
  return std::move(*model);
}

TEST(ExactStepper, UndampedModesKeepTheirEnergyForTenThousandPeriods) {
  const ModalModel model = undamped(crooked_tree(), 5);
  const double period_s = 1 / model.natural_frequency_hz(0);
  const ExactStepper stepper(model, period_s / 37);
  const Eigen::VectorXd no_force = Eigen::VectorXd::Zero(5);
  ModalState state{Eigen::VectorXd::LinSpaced(5, 0.01, 0.05), Eigen::VectorXd::LinSpaced(5, -0.3, 0.2)};
  const ModalState start = state;
  for (int i = 0; i < 37 * 10'000; ++i) stepper.advance(state, no_force, no_force, state);
  for (Eigen::Index mode = 0; mode < 5; ++mode) {  // each mode its own, not only their sum
    const auto energy = [&](const ModalState& s) {
      return s.q_dot[mode] * s.q_dot[mode] + model.stiffness_per_s2()[mode] * s.q[mode] * s.q[mode];
    };
    EXPECT_NEAR(energy(state) / energy(start), 1, 1e-9) << mode;
  }
  EXPECT_NEAR(energy_j(model, state) / energy_j(model, start), 1, 1e-9);
  // The first mode has done exactly 10,000 turns.
  EXPECT_NEAR(state.q[0], start.q[0], 1e-6 * std::abs(start.q[0]) + 1e-8);
}

TEST(ExactStepper, DampedDecayFollowsItsClosedForm) {
  ModalModel model = undamped(pole(10), 4);
  ASSERT_TRUE(model.set_parameters({.alpha_per_s = 0.4, .beta_s = 0.001}));
  const double step_s = 0.013;
  const ExactStepper stepper(model, step_s);
  const Eigen::VectorXd no_force = Eigen::VectorXd::Zero(4);
  ModalState state{Eigen::VectorXd::Constant(4, 0.1), Eigen::VectorXd::Zero(4)};
  for (int i = 1; i <= 1000; ++i) {
    stepper.advance(state, no_force, no_force, state);
    for (Eigen::Index mode = 0; mode < 4; ++mode) {
      const double t = i * step_s;
      const double half = model.damping_coefficient_per_s()[mode] / 2;
      const double w = std::sqrt(model.stiffness_per_s2()[mode] - half * half);
      const double truth = 0.1 * std::exp(-half * t) * (std::cos(w * t) + half / w * std::sin(w * t));
      ASSERT_NEAR(state.q[mode], truth, 1e-11) << "mode " << mode << " step " << i;
    }
  }
}

TEST(ExactStepper, ModalMassDividesTheForce) {
  ModalModel model = undamped(pole(10), 2);
  ASSERT_TRUE(model.set_parameters({.mass_factor = 3, .alpha_per_s = 50, .beta_s = 0}));
  const ExactStepper stepper(model, 1);
  const Eigen::VectorXd force = model.modal_force_at(10, {1, 0, 0});
  ModalState state = ModalState::at_rest(2);
  for (int i = 0; i < 100; ++i) stepper.advance(state, force, force, state);
  EXPECT_TRUE(state.q.isApprox(model.static_amplitudes(force), 1e-12));
}

TEST(ExactStepper, ExtraDampingIsPerModalMass) {
  ModalModel model = undamped(pole(10), 1);
  ASSERT_TRUE(model.set_parameters({.mass_factor = 2, .alpha_per_s = 0, .beta_s = 0}));
  const ExactStepper with(model, 0.01, Eigen::ArrayXd::Constant(1, 1.2));
  ASSERT_TRUE(model.set_parameters({.mass_factor = 2, .alpha_per_s = 0.6, .beta_s = 0}));
  const ExactStepper own(model, 0.01);
  ModalState a{Eigen::VectorXd::Constant(1, 1), Eigen::VectorXd::Zero(1)};
  ModalState b = a;
  const Eigen::VectorXd no_force = Eigen::VectorXd::Zero(1);
  for (int i = 0; i < 50; ++i) {
    with.advance(a, no_force, no_force, a);
    own.advance(b, no_force, no_force, b);
  }
  EXPECT_NEAR(a.q[0], b.q[0], 1e-15);
}

// ---- the thesis's stepping ----------------------------------------------------------------------------------------------

/// Longest step for w^2 dt^2 + 2 gamma dt = 4.
double longest_step(const ModalModel& model, Eigen::Index mode) {
  const double g = model.damping_coefficient_per_s()[mode];
  const double w2 = model.stiffness_per_s2()[mode];
  return (-g + std::sqrt(g * g + 4 * w2)) / w2;
}

TEST(SemiImplicitStepper, RefusesWhatIsUnstableAndNamesTheMode) {
  ModalModel model = undamped(pole(10), 6);
  ASSERT_TRUE(model.set_parameters({.alpha_per_s = 0.5, .beta_s = 0.002}));
  const double limit_s = longest_step(model, 5);
  EXPECT_TRUE(SemiImplicitStepper::make(model, 0.999 * limit_s).has_value());
  const auto refused = SemiImplicitStepper::make(model, 1.001 * limit_s);
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message, ::testing::HasSubstr("unstable"));
  EXPECT_THAT(refused.error().message, ::testing::HasSubstr("mode"));
  EXPECT_FALSE(SemiImplicitStepper::make(model, 0).has_value());
  // Damping shortens it.
  EXPECT_FALSE(SemiImplicitStepper::make(model, 0.999 * limit_s, Eigen::ArrayXd::Constant(6, 50)).has_value());
}

/// The recurrence itself, without the class's own guard: bounded below the limit, not above.
TEST(SemiImplicitStepper, TheLimitIsTheTrueOne) {
  ModalModel model = undamped(pole(10), 1);
  ASSERT_TRUE(model.set_parameters({.alpha_per_s = 3, .beta_s = 0}));
  const double w2 = model.stiffness_per_s2()[0];
  const double limit_s = longest_step(model, 0);
  const auto largest_root = [&](double dt) {
    const std::complex<double> trace = 2 - 3 * dt - w2 * dt * dt;
    const std::complex<double> root = std::sqrt(trace * trace / 4.0 - (1 - 3 * dt));
    return std::max(std::abs(trace / 2.0 + root), std::abs(trace / 2.0 - root));
  };
  EXPECT_LT(largest_root(0.999 * limit_s), 1);
  EXPECT_GT(largest_root(1.001 * limit_s), 1);
  auto stepper = SemiImplicitStepper::make(model, 0.99 * limit_s);
  ASSERT_TRUE(stepper.has_value());
  ModalState state{Eigen::VectorXd::Constant(1, 1), Eigen::VectorXd::Zero(1)};
  for (int i = 0; i < 3000; ++i) stepper->advance(state, Eigen::VectorXd::Zero(1), state);
  EXPECT_LT(std::abs(state.q[0]), 1);
}

TEST(SemiImplicitStepper, ConvergesToTheExactOneWithTheFirstPowerOfTheStep) {
  ModalModel model = undamped(pole(10), 1);
  ASSERT_TRUE(model.set_parameters({.alpha_per_s = 0.5, .beta_s = 0}));
  const Eigen::VectorXd force = model.modal_force_at(10, {1, 0, 0});
  const auto error = [&](int steps) {
    const double step_s = 1.0 / steps;
    const auto stepper = SemiImplicitStepper::make(model, step_s);
    EXPECT_TRUE(stepper.has_value());
    ModalState state = ModalState::at_rest(1);
    for (int i = 0; i < steps; ++i) stepper->advance(state, force, state);
    ModalState exact = ModalState::at_rest(1);
    ExactStepper(model, 1).advance(exact, force, force, exact);
    return std::abs(state.q[0] - exact.q[0]);
  };
  EXPECT_NEAR(std::log2(error(2000) / error(4000)), 1, 0.1);
}

}  // namespace
}  // namespace roseau::structure
