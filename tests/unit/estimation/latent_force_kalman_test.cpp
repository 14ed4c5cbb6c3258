#include "estimation/latent_force_kalman.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <numeric>

#include "tests/support/sway_simulation.h"

namespace roseau::estimation {
namespace {

using Eigen::Matrix3d;

LatentForceModel example_model() {
  LatentForceModel model;
  model.natural_frequency_hz = 1.1;
  model.damping_ratio = 0.04;
  model.sample_period_s = 1.0 / 25;
  model.noise_sd = 0.4;
  model.static_sd = 3;
  model.static_mean = 12;
  model.correlation_time_s = 5;
  return model;
}

// Stationary covariance of the state: X = F X F' + Q, by doubling.
Matrix3d stationary_covariance(const Matrix3d& transition, const Matrix3d& process_noise) {
  Matrix3d power = transition;
  Matrix3d sum = process_noise;
  for (int i = 0; i < 40; ++i) {
    sum = (sum + power * sum * power.transpose()).eval();
    power = (power * power).eval();
  }
  return sum;
}

// Process noise of the model, recovered from its own Riccati equation.
Matrix3d process_noise_of(const LatentForceGains& gains) {
  const Matrix3d& p = gains.predicted_covariance;
  const Matrix3d& f = gains.transition;
  const Matrix3d updated = p - p.col(0) * p.row(0) / gains.innovation_variance;
  return p - f * updated * f.transpose();
}

TEST(LatentForce, TransitionIsTheOscillatorUnderAHeldForce) {
  LatentForceModel model = example_model();
  model.correlation_time_s = 1e9;
  const auto gains = solve_gains(model, 0);
  // From rest at zero under a constant static displacement of 1: x = 1 - exp(-a t)(cos wd t + a/wd sin wd t).
  const double w0 = 2 * std::numbers::pi * model.natural_frequency_hz;
  const double a = model.damping_ratio * w0;
  const double damped = std::sqrt(w0 * w0 - a * a);
  const double t = model.sample_period_s;
  EXPECT_NEAR(gains.transition(0, 2), 1 - std::exp(-a * t) * (std::cos(damped * t) + a / damped * std::sin(damped * t)), 1e-9);
  EXPECT_NEAR(gains.transition(0, 0), std::exp(-a * t) * (std::cos(damped * t) + a / damped * std::sin(damped * t)), 1e-12);
  EXPECT_NEAR(gains.transition(2, 2), 1, 1e-9);
}

TEST(LatentForce, ProcessNoiseKeepsTheForcesSpread) {
  const LatentForceModel model = example_model();
  const auto gains = solve_gains(model, 0);
  const Matrix3d stationary = stationary_covariance(gains.transition, process_noise_of(gains));
  EXPECT_NEAR(std::sqrt(stationary(2, 2)), model.static_sd, 1e-6);
  EXPECT_NEAR(gains.transition(2, 2), std::exp(-model.sample_period_s / model.correlation_time_s), 1e-12);
}

TEST(LatentForce, RiccatiSolutionIsTheFiltersFixedPoint) {
  const auto gains = solve_gains(example_model(), 0);
  const Matrix3d noise = process_noise_of(gains);
  Matrix3d iterated = noise;
  for (int i = 0; i < 20000; ++i) {
    const double innovation = iterated(0, 0) + 0.16;
    const Matrix3d updated = iterated - iterated.col(0) * iterated.row(0) / innovation;
    iterated = gains.transition * updated * gains.transition.transpose() + noise;
  }
  EXPECT_LT((iterated - gains.predicted_covariance).cwiseAbs().maxCoeff(),
            1e-9 * gains.predicted_covariance.cwiseAbs().maxCoeff());
  EXPECT_NEAR(gains.innovation_variance, gains.predicted_covariance(0, 0) + 0.16, 1e-12);
}

TEST(LatentForce, RiccatiHoldsFromQuietToNoisyCameras) {
  for (const double noise_sd : {1e-9, 1e-3, 0.1, 1.0, 30.0}) {
    for (const double rate_hz : {4.0, 30.0, 200.0}) {
      LatentForceModel model = example_model();
      model.noise_sd = noise_sd;
      model.sample_period_s = 1 / rate_hz;
      const auto gains = solve_gains(model, 20);
      ASSERT_TRUE(gains.predicted_covariance.allFinite()) << noise_sd << " at " << rate_hz;
      const Eigen::Vector3d eigenvalues = gains.predicted_covariance.selfadjointView<Eigen::Lower>().eigenvalues();
      EXPECT_GT(eigenvalues.minCoeff(), -1e-9 * eigenvalues.maxCoeff());
      EXPECT_GE(gains.smoothed_variance, 0);
      EXPECT_LE(gains.smoothed_variance, gains.predicted_covariance(2, 2) * (1 + 1e-12));
    }
  }
}

// What the smoother says at a lag must be the best linear estimate from ALL samples up to then: computed here by brute force
// from the joint covariance of force and samples.
TEST(LatentForce, EqualsTheBruteForceBatchEstimate) {
  const LatentForceModel model = example_model();
  constexpr int kSamples = 300;
  testing::GaussianSource random(4);
  std::vector<double> samples;
  for (int i = 0; i < kSamples; ++i) samples.push_back(12 + 3 * std::sin(0.2 * i) + random.normal());

  for (const std::size_t lag : {0UL, 6UL, 25UL}) {
    const auto gains = solve_gains(model, lag);
    const Matrix3d stationary = stationary_covariance(gains.transition, process_noise_of(gains));
    std::vector<Matrix3d> ahead = {stationary};  // covariance of the state now with the state j samples before
    for (int j = 1; j < kSamples; ++j) ahead.push_back(gains.transition * ahead.back());
    Eigen::MatrixXd of_samples(kSamples, kSamples);
    Eigen::VectorXd of_force(kSamples);
    Eigen::VectorXd centred(kSamples);
    const int wanted = kSamples - 1 - static_cast<int>(lag);
    for (int i = 0; i < kSamples; ++i) {
      centred[i] = samples[static_cast<std::size_t>(i)] - model.static_mean;
      for (int j = 0; j <= i; ++j) {
        of_samples(i, j) = of_samples(j, i) = ahead[static_cast<std::size_t>(i - j)](0, 0) + (i == j ? 0.16 : 0);
      }
      of_force[i] =
          i <= wanted ? ahead[static_cast<std::size_t>(wanted - i)](2, 0) : ahead[static_cast<std::size_t>(i - wanted)](0, 2);
    }
    const Eigen::VectorXd weights = of_samples.ldlt().solve(of_force);
    const double expected = model.static_mean + weights.dot(centred);
    const double expected_variance = stationary(2, 2) - weights.dot(of_force);

    LatentForceKalman filter(model, lag);
    filter.start(samples[0]);
    std::optional<LatentForceKalman::Estimate> last;
    for (const double sample : samples) last = filter.step(sample);
    ASSERT_TRUE(last);
    EXPECT_NEAR(last->static_displacement, expected, 1e-6) << "lag " << lag;
    EXPECT_NEAR(last->sd * last->sd, expected_variance, 1e-8) << "lag " << lag;
    const double w0 = 2 * std::numbers::pi * model.natural_frequency_hz;
    EXPECT_NEAR(last->force_per_mass, w0 * w0 * expected, 1e-4);
  }
}

TEST(LatentForce, StatedSpreadIsTheRealOne) {
  // Samples of the filter's own model.
  LatentForceModel model = example_model();
  const auto gains = solve_gains(model, 6);
  const Eigen::LLT<Matrix3d> root(process_noise_of(gains) + 1e-15 * Matrix3d::Identity());
  const Matrix3d lower = root.matrixL();
  testing::GaussianSource random(11);
  Eigen::Vector3d state = Eigen::Vector3d::Zero();
  LatentForceKalman filter(model, 6);
  filter.start(model.static_mean);
  std::vector<double> truth;
  double square = 0;
  int count = 0;
  for (int i = 0; i < 40000; ++i) {
    truth.push_back(state[2] + model.static_mean);
    const auto estimate = filter.step(state[0] + model.static_mean + model.noise_sd * random.normal());
    if (estimate && i > 500) {
      square += std::pow(estimate->static_displacement - truth[truth.size() - 7], 2);
      ++count;
    }
    const double a = random.normal();
    const double b = random.normal();
    state = gains.transition * state + lower * Eigen::Vector3d(a, b, random.normal());
  }
  EXPECT_NEAR(std::sqrt(square / count) / std::sqrt(gains.smoothed_variance), 1, 0.05);
}

TEST(LatentForce, NewParametersBringNoJump) {
  testing::SwayOptions options;
  options.duration_s = 60;
  const auto sway = testing::simulate_sway(2, options);
  LatentForceModel model;
  model.static_mean = 14;
  model.static_sd = 6;
  model.noise_sd = 0.3;
  const auto run = [&](const LatentForceModel& later) {
    LatentForceKalman filter(model, 8);
    filter.start(sway.displacement_px[0]);
    std::vector<double> result;
    for (std::size_t i = 0; i < sway.displacement_px.size(); ++i) {
      if (i == 900) filter.set_model(later);
      if (const auto estimate = filter.step(sway.displacement_px[i])) result.push_back(estimate->static_displacement);
    }
    return result;
  };
  const auto steady = run(model);
  double largest_step = 0;
  for (std::size_t i = 300; i + 1 < steady.size(); ++i)
    largest_step = std::max(largest_step, std::abs(steady[i + 1] - steady[i]));
  // Against what the wind moves it by from frame to frame: another mean hardly shows, another oscillator only slowly.
  LatentForceModel other = model;
  other.static_mean = 4;
  const auto about_another_mean = run(other);
  other.natural_frequency_hz = 1.02;
  other.damping_ratio = 0.07;
  other.static_sd = 4;
  const auto changed = run(other);
  for (std::size_t i = 892; i < 905; ++i) {
    EXPECT_LT(std::abs(about_another_mean[i] - steady[i]), 0.2 * largest_step) << i;
    EXPECT_LT(std::abs(changed[i] - steady[i]), 0.8 * largest_step) << i;
  }
  EXPECT_NE(changed[1200], steady[1200]);

  // The same parameters again change not one bit.
  LatentForceKalman a(model, 8);
  LatentForceKalman b(model, 8);
  a.start(10);
  b.start(10);
  for (std::size_t i = 0; i < 200; ++i) {
    if (i == 100) b.set_model(model);
    const auto from_a = a.step(sway.displacement_px[i]);
    const auto from_b = b.step(sway.displacement_px[i]);
    if (!from_a) continue;
    EXPECT_EQ(from_a->static_displacement, from_b->static_displacement);
  }
}

TEST(LatentForce, MissingSamplesTeachNothingAndHurtLittle) {
  testing::SwayOptions options;
  options.duration_s = 120;
  const auto sway = testing::simulate_sway(6, options);
  LatentForceModel model;
  model.static_mean = 11;
  model.static_sd = 5;
  model.noise_sd = 0.3;
  LatentForceKalman filter(model, 8);
  filter.start(sway.displacement_px[0]);
  const double w0 = 2 * std::numbers::pi;
  double square = 0;
  int count = 0;
  for (std::size_t i = 0; i < sway.displacement_px.size(); ++i) {
    const bool missing = i % 10 == 3 || (i % 200) < 3;
    const auto estimate = filter.step(missing ? std::nullopt : std::optional(sway.displacement_px[i]));
    if (!estimate || i < 300) continue;
    square += std::pow(estimate->force_per_mass - sway.force[i - 8], 2);
    ++count;
  }
  const double spread = 5 * w0 * w0;
  EXPECT_LT(std::sqrt(square / count), 0.25 * spread);

  // Nothing but missing samples: the force relaxes to its mean.
  std::optional<LatentForceKalman::Estimate> last;
  for (int i = 0; i < 3000; ++i) last = filter.step(std::nullopt);
  EXPECT_NEAR(last->static_displacement, model.static_mean, 1e-3);
}

TEST(LatentForce, StateCanBeCarriedToAnotherFilter) {
  LatentForceKalman filter(example_model(), 5);
  filter.start(12);
  for (int i = 0; i < 50; ++i) (void)filter.step(12 + std::sin(0.3 * i));
  LatentForceKalman other(example_model(), 5);
  ASSERT_TRUE(other.restore(filter.state()));
  for (int i = 50; i < 80; ++i) {
    EXPECT_EQ(filter.step(12 + std::sin(0.3 * i))->static_displacement,
              other.step(12 + std::sin(0.3 * i))->static_displacement);
  }
  LatentForceKalman shorter(example_model(), 2);
  EXPECT_FALSE(shorter.restore(filter.state()));
}

}  // namespace
}  // namespace roseau::estimation
