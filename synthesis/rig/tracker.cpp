#include "synthesis/rig/tracker.h"

#include <algorithm>
#include <utility>

#include "core/check.h"

namespace roseau::synthesis {

std::shared_ptr<const MagneticTracker> make_tracker(const std::shared_ptr<const World>& world) {
  const Scene& scene = world->scene();
  if (!scene.tracker.enabled || world->balls().empty()) return nullptr;
  MagneticTrackerOptions options = scene.tracker.instrument;
  options.station_count = std::min(options.station_count, static_cast<std::int64_t>(world->balls().size()));
  auto tracker = MagneticTracker::make("tracker", options, scene.seed, world);
  ROSEAU_CHECK(tracker.has_value());
  return std::move(*tracker);
}

}  // namespace roseau::synthesis
