#include "recorder/tools/merge/clock_shift.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace roseau::recorder {

CivilOffset::CivilOffset(std::vector<std::pair<HostTime, Duration>> points) : points_(std::move(points)) {
  ROSEAU_CHECK(!points_.empty());
  for (std::size_t i = 1; i < points_.size(); ++i) ROSEAU_CHECK(points_[i - 1].first < points_[i].first);
}

Duration CivilOffset::at(HostTime time) const {
  ROSEAU_CHECK(is_known());
  const auto next = std::ranges::upper_bound(points_, time, {}, [](const auto& point) { return point.first; });
  if (next == points_.begin()) return points_.front().second;
  if (next == points_.end()) return points_.back().second;
  const auto& before = *std::prev(next);
  const double share = to_seconds(time - before.first) / to_seconds(next->first - before.first);
  const auto change_ns = static_cast<double>((next->second - before.second).count());
  return before.second + Duration{std::llround(share * change_ns)};
}

HostTime moved(HostTime time, const CivilOffset& from, const CivilOffset& to) {
  const HostTime civil = time + from.at(time);
  if (to.is_constant()) return civil - to.at(civil);
  // What is to be found is on both sides. Offsets change by parts in 10^5 of the time, so each round gains five digits.
  constexpr int kRounds = 4;
  HostTime found = civil - to.points().front().second;
  for (int i = 0; i < kRounds; ++i) found = civil - to.at(found);
  return found;
}

}  // namespace roseau::recorder
