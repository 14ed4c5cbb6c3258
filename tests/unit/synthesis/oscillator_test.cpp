#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "synthesis/oscillator/branch_motion.h"
#include "synthesis/oscillator/damped_oscillator.h"
#include "synthesis/wind/turbulent_wind.h"

namespace roseau::synthesis {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

TEST(DampedOscillator, FreeDecayIsTheClosedForm) {
  const DampedOscillator oscillator(1.2, 0.05);
  const double w0 = kTwoPi * 1.2;
  const double wd = w0 * std::sqrt(1 - 0.05 * 0.05);
  OscillatorState state{1, 0};
  double time_s = 0;
  for (int i = 0; i < 500; ++i) {
    state = oscillator.step(state, 0, 0, 0.01);
    time_s += 0.01;
  }
  const double expected = std::exp(-0.05 * w0 * time_s) * (std::cos(wd * time_s) + 0.05 * w0 / wd * std::sin(wd * time_s));
  EXPECT_NEAR(state.position, expected, 1e-12);
}

TEST(DampedOscillator, SettlesAtForceOverStiffness) {
  const DampedOscillator oscillator(2, 0.1);
  OscillatorState state;
  for (int i = 0; i < 4000; ++i) state = oscillator.step(state, 3, 3, 0.01);
  EXPECT_NEAR(state.position, 3 / std::pow(kTwoPi * 2, 2), 1e-12);
  EXPECT_NEAR(state.velocity_per_s, 0, 1e-12);
}

TEST(DampedOscillator, OneStepUnderALinearForceEqualsMany) {
  const DampedOscillator oscillator(0.7, 0.2);
  const OscillatorState begin{0.3, -1.1};
  const OscillatorState at_once = oscillator.step(begin, 2, -5, 1.5);
  OscillatorState state = begin;
  for (int i = 0; i < 300; ++i) state = oscillator.step(state, 2 - 7 * i / 300.0, 2 - 7 * (i + 1) / 300.0, 1.5 / 300);
  EXPECT_NEAR(state.position, at_once.position, 1e-11);
  EXPECT_NEAR(state.velocity_per_s, at_once.velocity_per_s, 1e-11);
}

TEST(DampedOscillator, EnergyChangesByWorkOfForceAndDamping) {
  const DampedOscillator oscillator(1.5, 0.08);
  const double w2 = std::pow(oscillator.angular_frequency_rad_s(), 2);
  const auto energy = [w2](const OscillatorState& s) {
    return 0.5 * (s.velocity_per_s * s.velocity_per_s + w2 * s.position * s.position);
  };
  const double dt = 1e-4;
  OscillatorState state{0.2, 0.5};
  const double before = energy(state);
  double work = 0;
  const auto power = [&](const OscillatorState& s, double force) {
    return (force - oscillator.damping_coefficient_per_s() * s.velocity_per_s) * s.velocity_per_s;
  };
  for (int i = 0; i < 20000; ++i) {
    const double force_begin = std::sin(3.0 * i * dt);
    const double force_end = std::sin(3.0 * (i + 1) * dt);
    const OscillatorState next = oscillator.step(state, force_begin, force_end, dt);
    work += 0.5 * dt * (power(state, force_begin) + power(next, force_end));
    state = next;
  }
  EXPECT_NEAR(energy(state) - before, work, 1e-6);
}

TEST(DampedOscillator, ResonatesAtTheStatedGain) {
  const DampedOscillator oscillator(1, 0.05);
  const double w0 = kTwoPi;
  OscillatorState state;
  double largest = 0;
  for (int i = 0; i < 40 * 1000; ++i) {
    state = oscillator.step(state, std::sin(w0 * i / 1000), std::sin(w0 * (i + 1) / 1000), 1e-3);
    if (i > 35 * 1000) largest = std::max(largest, std::abs(state.position));
  }
  EXPECT_NEAR(largest * oscillator.damping_coefficient_per_s() * w0, 1, 1e-3);
}

class SteadyWind final : public WindField {
 public:
  explicit SteadyWind(Vec3 velocity) : velocity_(velocity) {}
  Vec3 velocity_mps(const Vec3&, double) const override { return velocity_; }

 private:
  Vec3 velocity_;
};

double steady_deflection_m(const BranchMotionOptions& options, Vec3 velocity) {
  return BranchMotion(options, 4, std::make_shared<SteadyWind>(velocity)).deflection_m(3);
}

TEST(BranchMotion, MeanWindGivesTheMeanDeflection) {
  EXPECT_NEAR(steady_deflection_m({.mean_deflection_m = 0.06}, {4, 0, 0}), 0.06, 1e-9);
  EXPECT_NEAR(steady_deflection_m({.mean_deflection_m = 0.06}, {-4, 0, 0}), -0.06, 1e-9);
  EXPECT_NEAR(steady_deflection_m({.mean_deflection_m = 0.06}, {0, 4, 0}), 0, 1e-9);
}

TEST(BranchMotion, DragGrowsWithItsExponent) {
  EXPECT_NEAR(steady_deflection_m({.drag_exponent = 2, .mean_deflection_m = 0.06}, {8, 0, 0}), 0.24, 1e-9);
  EXPECT_NEAR(steady_deflection_m({.drag_exponent = 1.4, .mean_deflection_m = 0.06}, {8, 0, 0}), 0.06 * std::pow(2, 1.4), 1e-9);
  // Wind at 45 degrees: the whole speed drags, the axis feels its part.
  EXPECT_NEAR(steady_deflection_m({.drag_exponent = 2, .mean_deflection_m = 0.06}, {4, 4, 0}), 0.06 * std::sqrt(2), 1e-9);
}

TEST(BranchMotion, IsAPureFunctionOfTime) {
  const Vec3 here{0, 0, 2.6};
  const auto wind = std::make_shared<TurbulentWind>(TurbulentWindOptions{}, 5, std::vector{here});
  const BranchMotionOptions options{.drag_point_in_world = here};
  BranchMotion often(options, 4, wind);
  BranchMotion seldom(options, 4, wind);
  double at_end = 0;
  for (int i = 0; i <= 300; ++i) at_end = often.deflection_m(i / 30.0);
  EXPECT_EQ(seldom.deflection_m(10), at_end);
  EXPECT_EQ(often.deflection_m(1.0 / 3), BranchMotion(options, 4, wind).deflection_m(1.0 / 3));  // back in time
}

TEST(BranchMotion, ObeysItsEquationInTurbulence) {
  const Vec3 here{0, 0, 2.6};
  const auto wind = std::make_shared<TurbulentWind>(TurbulentWindOptions{}, 5, std::vector{here});
  const BranchMotionOptions options{.natural_frequency_hz = 0.8, .damping_ratio = 0.1, .drag_point_in_world = here};
  BranchMotion motion(options, 4, wind);
  const double w0 = kTwoPi * 0.8;
  const double dt = 1e-3;
  for (double time_s = 1; time_s < 20; time_s += 1.7) {
    const double before = motion.deflection_m(time_s - dt);
    const double now = motion.deflection_m(time_s);
    const double after = motion.deflection_m(time_s + dt);
    const double left = (after - 2 * now + before) / (dt * dt) + 2 * 0.1 * w0 * (after - before) / (2 * dt) + w0 * w0 * now;
    EXPECT_NEAR(left, motion.force_per_mass_mps2(time_s), 0.01 * w0 * w0 * options.mean_deflection_m) << time_s;
  }
}

}  // namespace
}  // namespace roseau::synthesis
