#include "synthesis/wind/sum_of_winds.h"

#include <algorithm>
#include <array>

namespace roseau::synthesis {

SumOfWinds::SumOfWinds(std::vector<std::shared_ptr<const WindField>> winds) : winds_(std::move(winds)) {
  ROSEAU_CHECK(std::ranges::none_of(winds_, [](const auto& wind) { return wind == nullptr; }));
}

Vec3 SumOfWinds::velocity_mps(const Vec3& point_in_world, double time_s) const {
  Vec3 sum;
  velocities_mps({&point_in_world, 1}, time_s, {&sum, 1});
  return sum;
}

void SumOfWinds::velocities_mps(std::span<const Vec3> points_in_world, double time_s, std::span<Vec3> out) const {
  ROSEAU_CHECK(out.size() == points_in_world.size());
  constexpr std::size_t kBlock = 256;
  std::array<Vec3, kBlock> part;
  for (std::size_t first = 0; first < out.size(); first += kBlock) {
    const auto points = points_in_world.subspan(first, std::min(kBlock, out.size() - first));
    const auto sums = out.subspan(first, points.size());
    std::ranges::fill(sums, Vec3{});
    for (const auto& wind : winds_) {
      wind->velocities_mps(points, time_s, std::span(part).first(points.size()));
      for (std::size_t i = 0; i < sums.size(); ++i) {
        sums[i] = {sums[i].x + part[i].x, sums[i].y + part[i].y, sums[i].z + part[i].z};
      }
    }
  }
}

}  // namespace roseau::synthesis
