#include "structure/animation/oscillator_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace roseau::structure {
namespace {

struct State {
  double q = 0;
  double rate = 0;
};

State advance(const OscillatorStep& step, const State& state, double start_force, double end_force) {
  return {state.q + step.q_less_one_from_q * state.q + step.q_from_rate * state.rate + step.q_from_start_force * start_force +
              step.q_from_end_force * end_force,
          state.rate + step.rate_from_q * state.q + step.rate_less_one_from_rate * state.rate +
              step.rate_from_start_force * start_force + step.rate_from_end_force * end_force};
}

constexpr double kFrequencyHz = 0.8;
const double kOmega = 2 * std::numbers::pi * kFrequencyHz;

// Free motion from (q, rate), under-damped.
State free_motion(double gamma_per_s, const State& start, double time_s) {
  const double damped = std::sqrt(kOmega * kOmega - gamma_per_s * gamma_per_s / 4);
  const double decay = std::exp(-gamma_per_s * time_s / 2);
  const double c = std::cos(damped * time_s);
  const double s = std::sin(damped * time_s);
  const double sine = (start.rate + gamma_per_s / 2 * start.q) / damped;
  const double q = decay * (start.q * c + sine * s);
  return {q, -gamma_per_s / 2 * q + decay * damped * (sine * c - start.q * s)};
}

TEST(OscillatorStep, FreeDecayIsTheClosedFormEvenOverThreePeriods) {
  const double gamma_per_s = 0.7;
  for (const double step_s : {1e-4, 0.02, 0.4, 3 / kFrequencyHz}) {
    const State start{0.3, -1.1};
    const State end = advance(oscillator_step(kFrequencyHz, gamma_per_s, step_s), start, 0, 0);
    const State exact = free_motion(gamma_per_s, start, step_s);
    EXPECT_NEAR(end.q, exact.q, 1e-12) << step_s;
    EXPECT_NEAR(end.rate, exact.rate, 1e-12) << step_s;
  }
}

TEST(OscillatorStep, OverdampedAndCriticalDecaysAreTheirClosedForms) {
  const double step_s = 0.3;
  const State start{1, 0};
  const double critical = 2 * kOmega;
  State end = advance(oscillator_step(kFrequencyHz, critical, step_s), start, 0, 0);
  EXPECT_NEAR(end.q, (1 + kOmega * step_s) * std::exp(-kOmega * step_s), 1e-12);

  const double gamma_per_s = 5 * kOmega;
  end = advance(oscillator_step(kFrequencyHz, gamma_per_s, step_s), start, 0, 0);
  const double root = std::sqrt(gamma_per_s * gamma_per_s / 4 - kOmega * kOmega);
  const double slow = -gamma_per_s / 2 + root;
  const double fast = -gamma_per_s / 2 - root;
  EXPECT_NEAR(end.q, (slow * std::exp(fast * step_s) - fast * std::exp(slow * step_s)) / (slow - fast), 1e-12);
}

TEST(OscillatorStep, ForceThatGrowsLinearlyIsExact) {
  const double gamma_per_s = 0.7;
  const double step_s = 0.9;
  const double slope = 2.5;
  const double force = -0.4;
  const double stiffness = kOmega * kOmega;
  // The motion that follows the ramp, and free motion for the rest of the start's state.
  const auto ramp = [&](double time_s) {
    return State{(force + slope * time_s) / stiffness - gamma_per_s * slope / (stiffness * stiffness), slope / stiffness};
  };
  const State start{0.3, -1.1};
  const State rest = free_motion(gamma_per_s, {start.q - ramp(0).q, start.rate - ramp(0).rate}, step_s);
  const State end = advance(oscillator_step(kFrequencyHz, gamma_per_s, step_s), start, force, force + slope * step_s);
  EXPECT_NEAR(end.q, ramp(step_s).q + rest.q, 1e-12);
  EXPECT_NEAR(end.rate, ramp(step_s).rate + rest.rate, 1e-12);
}

TEST(OscillatorStep, NoTimeChangesNothing) {
  const State end = advance(oscillator_step(kFrequencyHz, 0.7, 0), {0.3, -1.1}, 4, 5);
  EXPECT_EQ(end.q, 0.3);
  EXPECT_EQ(end.rate, -1.1);
}

}  // namespace
}  // namespace roseau::structure
