#include "estimation/latent_force_kalman.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

#include "core/check.h"

namespace roseau::estimation {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// A noise-free series still needs a positive noise in the filter; this much below the static spread is below any tracker.
constexpr double kSmallestNoise = 1e-4;

double angular(double hz) { return 2 * std::numbers::pi * hz; }

struct DiscreteModel {
  Matrix3d transition;
  Matrix3d process_noise;
};

// Van Loan's method: transition and process noise of one step from one matrix exponential.
DiscreteModel discretise(const LatentForceModel& model) {
  const double w0 = angular(model.natural_frequency_hz);
  const double gamma = 2 * model.damping_ratio * w0;
  Matrix3d rate = Matrix3d::Zero();
  rate << 0, w0, 0, -w0, -gamma, w0, 0, 0, -1 / model.correlation_time_s;
  Matrix3d diffusion = Matrix3d::Zero();
  diffusion(2, 2) = 2 * model.static_sd * model.static_sd / model.correlation_time_s;

  Matrix6d block = Matrix6d::Zero();
  block.topLeftCorner<3, 3>() = -rate;
  block.topRightCorner<3, 3>() = diffusion;
  block.bottomRightCorner<3, 3>() = rate.transpose();
  const Matrix6d exponential = (block * model.sample_period_s).exp();
  DiscreteModel discrete;
  discrete.transition = exponential.bottomRightCorner<3, 3>().transpose();
  const Matrix3d noise = discrete.transition * exponential.topRightCorner<3, 3>();
  discrete.process_noise = (noise + noise.transpose()) / 2;
  return discrete;
}

}  // namespace

Matrix3d solve_riccati(const Matrix3d& transition, const Matrix3d& process_noise, double noise_variance) {
  Matrix3d a = transition.transpose();
  Matrix3d g = Matrix3d::Zero();
  g(0, 0) = 1 / noise_variance;
  Matrix3d h = process_noise;
  for (int doubling = 0; doubling < 60; ++doubling) {
    const Matrix3d inverse = (Matrix3d::Identity() + g * h).inverse();
    const Matrix3d next_h = h + a.transpose() * h * inverse * a;
    const Matrix3d next_g = g + a * inverse * g * a.transpose();
    a = (a * inverse * a).eval();
    const double change = (next_h - h).cwiseAbs().maxCoeff();
    h = (next_h + next_h.transpose()) / 2;
    g = (next_g + next_g.transpose()) / 2;
    if (change <= 1e-14 * h.cwiseAbs().maxCoeff()) break;
  }
  return h;
}

// What is left of an error that counts as gone, and a bound for models whose filter hardly listens to its samples.
constexpr double kSettled = 0.05;
constexpr double kSlowestPole = 0.999;

LatentForceGains solve_gains(const LatentForceModel& model, std::size_t lag_samples) {
  ROSEAU_CHECK(model.natural_frequency_hz > 0 && model.damping_ratio > 0 && model.sample_period_s > 0);
  ROSEAU_CHECK(model.static_sd > 0 && model.correlation_time_s > 0);
  const double noise_sd = std::max(model.noise_sd, kSmallestNoise * model.static_sd);
  const DiscreteModel discrete = discretise(model);

  LatentForceGains gains;
  gains.transition = discrete.transition;
  gains.predicted_covariance = solve_riccati(discrete.transition, discrete.process_noise, noise_sd * noise_sd);
  gains.innovation_variance = gains.predicted_covariance(0, 0) + noise_sd * noise_sd;
  gains.gain = gains.predicted_covariance.col(0) / gains.innovation_variance;

  // The error of u at k and the innovation at k+j have covariance [P (Phi')^j H']_u with Phi = F (I - K H).
  Matrix3d phi = -discrete.transition * gains.gain * Vector3d::UnitX().transpose();
  phi += discrete.transition;
  Vector3d direction = Vector3d::UnitX();
  gains.smoothed_variance = gains.predicted_covariance(2, 2);
  for (std::size_t j = 0; j <= lag_samples; ++j) {
    const double coefficient = gains.predicted_covariance.row(2).dot(direction) / gains.innovation_variance;
    gains.smoother_coefficients.push_back(coefficient);
    gains.smoothed_variance -= coefficient * coefficient * gains.innovation_variance;
    direction = (phi.transpose() * direction).eval();
  }
  gains.smoothed_variance = std::max(gains.smoothed_variance, 0.0);
  const double slowest_pole = phi.eigenvalues().cwiseAbs().maxCoeff();
  gains.settling_samples =
      static_cast<std::size_t>(std::ceil(std::log(kSettled) / std::log(std::min(slowest_pole, kSlowestPole))));
  return gains;
}

LatentForceKalman::LatentForceKalman(const LatentForceModel& model, std::size_t lag_samples)
    : model_(model), lag_samples_(lag_samples), gains_(solve_gains(model, lag_samples)) {}

void LatentForceKalman::start(double displacement) {
  const double from_mean = displacement - model_.static_mean;
  state_.state = {from_mean, 0, from_mean};
  state_.predicted.clear();
  state_.innovations.clear();
}

std::optional<LatentForceKalman::Estimate> LatentForceKalman::step(std::optional<double> displacement) {
  Vector3d& state = state_.state;
  const double innovation = displacement ? *displacement - model_.static_mean - state[0] : 0.0;
  if (state_.predicted.size() > lag_samples_) {
    state_.predicted.erase(state_.predicted.begin());
    state_.innovations.erase(state_.innovations.begin());
  }
  state_.predicted.push_back(state[2] + model_.static_mean);
  state_.innovations.push_back(innovation);
  state = (gains_.transition * (state + gains_.gain * innovation)).eval();
  if (state_.predicted.size() <= lag_samples_) return std::nullopt;

  Estimate estimate;
  estimate.static_displacement = state_.predicted.front();
  for (std::size_t j = 0; j <= lag_samples_; ++j) {
    estimate.static_displacement += gains_.smoother_coefficients[j] * state_.innovations[j];
  }
  const double w0 = angular(model_.natural_frequency_hz);
  estimate.sd = std::sqrt(gains_.smoothed_variance);
  estimate.force_per_mass = w0 * w0 * estimate.static_displacement;
  estimate.force_per_mass_sd = w0 * w0 * estimate.sd;
  return estimate;
}

void LatentForceKalman::set_model(const LatentForceModel& model) {
  // Position, velocity and static displacement stay what they are; only what they are counted from and in changes.
  const double shift = model_.static_mean - model.static_mean;
  state_.state[0] += shift;
  state_.state[1] *= model_.natural_frequency_hz / model.natural_frequency_hz;
  state_.state[2] += shift;
  model_ = model;
  gains_ = solve_gains(model, lag_samples_);
}

bool LatentForceKalman::restore(State state) {
  if (state.predicted.size() != state.innovations.size() || state.predicted.size() > lag_samples_ + 1) return false;
  state_ = std::move(state);
  return true;
}

}  // namespace roseau::estimation
