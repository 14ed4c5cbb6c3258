// Winds simple enough to know by heart.
#pragma once

#include <functional>
#include <utility>

#include "core/wind_field.h"

namespace roseau::testing {

/// The same everywhere, a function of time.
class UniformWind : public WindField {
 public:
  explicit UniformWind(Vec3 velocity) : velocity_([velocity](double) { return velocity; }) {}
  explicit UniformWind(std::function<Vec3(double)> velocity) : velocity_(std::move(velocity)) {}
  Vec3 velocity_mps(const Vec3& /*point*/, double time_s) const override { return velocity_(time_s); }

 private:
  std::function<Vec3(double)> velocity_;
};

/// Steady, along x, growing with height.
class ShearedWind : public WindField {
 public:
  ShearedWind(double foot_mps, double per_s) : foot_mps_(foot_mps), per_s_(per_s) {}
  Vec3 velocity_mps(const Vec3& point, double /*time_s*/) const override { return {foot_mps_ + per_s_ * point.z, 0, 0}; }

 private:
  double foot_mps_;
  double per_s_;
};

}  // namespace roseau::testing
