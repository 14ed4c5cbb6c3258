// The force on an oscillator, on line: Kalman filter on (displacement, velocity, force) and fixed-lag smoother, both in steady
// state (VIDA thesis chapter 5 turned into a filter; docs/estimation.md has the equations).
//
//   x'' + g x' + w0^2 x = w0^2 u,   u' = -(u - mean)/tau + white,   y = x + noise
//
// u is the STATIC DISPLACEMENT: where the target would stand if the present force stayed. Force per mass is w0^2 u. The filter
// carries u and not the force because w0 is re-estimated while it runs: u then stays where it is, the force would jump.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/result.h"

namespace roseau::estimation {

struct LatentForceModel {
  double natural_frequency_hz = 1;
  double damping_ratio = 0.05;
  double sample_period_s = 1.0 / 30;
  double noise_sd = 0.1;  // of one displacement sample, white
  double static_sd = 1;   // spread of the static displacement about its mean, unit of the displacement
  double static_mean = 0;
  double correlation_time_s = 8;  // tau

  template <class Archive>
  void archive(Archive& a) {
    a(natural_frequency_hz), a(damping_ratio), a(sample_period_s), a(noise_sd), a(static_sd), a(static_mean);
    a(correlation_time_s);
  }
};

/// Steady-state gains of a model, independent of the data. Pure.
struct LatentForceGains {
  Eigen::Matrix3d transition;                 // of (x, x'/w0, u) about the mean over one sample period
  Eigen::Vector3d gain;                       // K = P H' / S
  Eigen::Matrix3d predicted_covariance;       // P, of the state before its sample is seen
  double innovation_variance = 0;             // S
  std::vector<double> smoother_coefficients;  // c_j: u^(k|k+L) = u^(k|k-1) + sum_j c_j e(k+j), j = 0..L
  double smoothed_variance = 0;               // of u at that lag: P_uu - S sum c_j^2
  std::size_t settling_samples = 0;           // until an error of the state has fallen to 5 %: poles of F (I - K H)
};

LatentForceGains solve_gains(const LatentForceModel& model, std::size_t lag_samples);

/// Solves P = F P F' - F P H' (H P H' + r)^-1 H P F' + Q for H = (1 0 0) by structure-preserving doubling: 8-12 products of 3x3
/// matrices instead of thousands of filter steps.
Eigen::Matrix3d solve_riccati(const Eigen::Matrix3d& transition, const Eigen::Matrix3d& process_noise, double noise_variance);

/// One step costs a 3-state update and L+1 multiply-adds.
class LatentForceKalman {
 public:
  struct Estimate {
    double static_displacement = 0;
    double sd = 0;
    double force_per_mass = 0;  // w0^2 u
    double force_per_mass_sd = 0;
  };

  LatentForceKalman(const LatentForceModel& model, std::size_t lag_samples);

  /// Begins (again) at rest at this displacement: everything before is forgotten.
  void start(double displacement);

  /// One sample period later. nullopt: no sample came; the state is predicted and nothing learned. Returns the estimate for
  /// the sample `lag_samples` before this one, once there is one.
  std::optional<Estimate> step(std::optional<double> displacement);

  /// New parameters from the next step on; state, predictions and innovations are carried over, so that the estimate has no
  /// jump. The lag stays.
  void set_model(const LatentForceModel& model);

  const LatentForceModel& model() const { return model_; }
  const LatentForceGains& gains() const { return gains_; }
  std::size_t lag_samples() const { return lag_samples_; }

  /// Everything that steps change, for a checkpoint. restore() CHECKs nothing: it returns false when sizes do not fit.
  struct State {
    Eigen::Vector3d state = Eigen::Vector3d::Zero();  // x - mean, x'/w0, u - mean: predicted for the next sample
    std::vector<double> predicted;                    // u^(k|k-1) of the last lag+1 samples, oldest first, mean included
    std::vector<double> innovations;                  // of the same samples; 0 where none came

    template <class Archive>
    void archive(Archive& a) {
      a(state[0]), a(state[1]), a(state[2]), a(predicted), a(innovations);
    }
  };
  const State& state() const { return state_; }
  [[nodiscard]] bool restore(State state);

 private:
  LatentForceModel model_;
  std::size_t lag_samples_;
  LatentForceGains gains_;
  State state_;
};

}  // namespace roseau::estimation
