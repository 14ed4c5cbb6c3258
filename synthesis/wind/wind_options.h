// WindOptions: the wind of a scene, of whatever kinds, on top of each other.
//
// Nothing at all is calm air. Turbulence of intensity 0 is a steady wind with a profile. A recording takes the place of
// turbulence. Primitives and gusts are added.
//
// Keys in files are the members' names: [wind] holds TurbulentWindOptions, [wind.recording], [[wind.primitive]] and
// [[wind.gust]] the others.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "core/wind_field.h"
#include "synthesis/wind/flow_primitive.h"
#include "synthesis/wind/gust_front.h"
#include "synthesis/wind/recorded_wind.h"
#include "synthesis/wind/turbulent_wind.h"
#include "synthesis/wind/wind_region.h"

namespace roseau::synthesis {

struct WindOptions {
  std::optional<TurbulentWindOptions> turbulence = TurbulentWindOptions{};  // none, or of mean_speed_mps = 0: calm
  std::optional<RecordedWindOptions> recording;
  std::vector<FlowPrimitive> primitives;
  std::vector<GustFront> gusts;
};

/// One thing that makes no sense.
struct WindProblem {
  std::string_view section;  // "wind", "wind.recording", "wind.primitive", "wind.gust"
  std::size_t index = 0;     // which primitive or gust
  std::string_view key;
  std::string what;  // "must be ..."
};

void find_problems(const WindOptions& options, const std::function<void(const WindProblem&)>& report);

/// The first problem, in words that name the key; nothing when all is well.
Result<void> check(const WindOptions& options);

/// The mean wind at the reference height (turbulence or recording, else the sum of the uniform primitives): what carries
/// primitives that drift. Gusts not counted.
Vec3 mean_wind_mps(const WindOptions& options);

/// The wind of these options over a region. The same options, seed and region give the same wind. Error: what check() finds, a
/// lattice too large, a recording too short.
Result<std::shared_ptr<const WindField>> make_wind(const WindOptions& options, std::uint64_t seed, const WindRegion& region);

}  // namespace roseau::synthesis
