// SumOfWinds: fields on top of each other, as the flow primitives of the plant thesis (5.2.2) are meant to be used. Of no
// field at all: calm air.
#pragma once

#include <memory>
#include <vector>

#include "core/wind_field.h"

namespace roseau::synthesis {

class SumOfWinds final : public WindField {
 public:
  explicit SumOfWinds(std::vector<std::shared_ptr<const WindField>> winds);

  Vec3 velocity_mps(const Vec3& point_in_world, double time_s) const override;
  void velocities_mps(std::span<const Vec3> points_in_world, double time_s, std::span<Vec3> out) const override;

 private:
  std::vector<std::shared_ptr<const WindField>> winds_;
};

}  // namespace roseau::synthesis
