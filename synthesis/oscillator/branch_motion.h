// BranchMotion: one mode of a branch in the wind. The drag of the air at one point drives it,
//   x'' + gamma x' + w0^2 x = drag_gain |V|^(n-1) (V . axis),
// x in metres at the branch's reference point along `axis`. The gain is given by the deflection under the mean wind.
#pragma once

#include <cstdint>
#include <memory>

#include "core/wind_field.h"
#include "synthesis/oscillator/damped_oscillator.h"

namespace roseau::synthesis {

struct BranchMotionOptions {
  double natural_frequency_hz = 1.2;
  double damping_ratio = 0.05;
  double drag_exponent = 2;           // n: 2 = rigid body; 2 + Vogel exponent for foliage that streamlines itself
  double mean_deflection_m = 0.0625;  // static, under a steady wind of `mean_speed_mps` along the axis
  Vec3 axis_in_world{1, 0, 0};        // unit vector of the motion
  Vec3 drag_point_in_world;           // where the wind is felt
};

/// A pure function of time, made fast for times that do not go back: it keeps its place on a fixed grid of steps, so that any
/// two objects made alike give the same bits at the same time, however each got there. One thread at a time.
class BranchMotion {
 public:
  BranchMotion(const BranchMotionOptions& options, double mean_speed_mps, std::shared_ptr<const WindField> wind);

  /// Deflection in metres. A time before the last one asked for starts over from the beginning: correct, but slow.
  double deflection_m(double time_s);

  /// m/s^2 along the axis.
  double force_per_mass_mps2(double time_s) const;

  /// Component of the air's velocity at the drag point along the axis.
  double wind_along_axis_mps(double time_s) const;

 private:
  void restart();

  BranchMotionOptions options_;
  std::shared_ptr<const WindField> wind_;
  DampedOscillator oscillator_;
  double drag_gain_;
  std::int64_t first_step_;  // before time 0: by then the start is forgotten

  std::int64_t step_ = 0;  // the state below is at this step
  OscillatorState state_;
  double force_ = 0;
  double next_force_ = 0;
};

}  // namespace roseau::synthesis
