// The scene's magnetic tracker: a station in each ball.
#pragma once

#include <memory>

#include "synthesis/instruments/magnetic_tracker.h"
#include "synthesis/rig/world.h"

namespace roseau::synthesis {

/// Null when the scene has none, or no balls. World::build() has tried its options.
std::shared_ptr<const MagneticTracker> make_tracker(const std::shared_ptr<const World>& world);

}  // namespace roseau::synthesis
