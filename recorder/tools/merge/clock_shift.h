// From one host's monotonic time to another's, by what both say about civil time. Pure.
//
// A session says once what civil time minus host time was (utc_minus_host_time_ns). Where the host also recorded its clock
// against civil time while it ran (a stream of ClockState whose device is "utc": host = utc + offset), that goes before it,
// with straight lines between its samples.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "core/time.h"

namespace roseau::recorder {

/// What civil time minus host time was, by host time.
class CivilOffset {
 public:
  CivilOffset() = default;
  explicit CivilOffset(Duration constant) : points_{{HostTime{}, constant}} {}
  /// Times must increase; at least one.
  explicit CivilOffset(std::vector<std::pair<HostTime, Duration>> points);

  /// Before the first and behind the last point: as at that point.
  Duration at(HostTime time) const;
  bool is_known() const { return !points_.empty(); }
  bool is_constant() const { return points_.size() == 1; }
  const std::vector<std::pair<HostTime, Duration>>& points() const { return points_; }

 private:
  std::vector<std::pair<HostTime, Duration>> points_;
};

/// `time` of a host with clock `from`, on the axis of a host with clock `to`.
HostTime moved(HostTime time, const CivilOffset& from, const CivilOffset& to);

}  // namespace roseau::recorder
