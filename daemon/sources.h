// From the configuration to sample sources: devices, or the simulated rig in their place.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/sample.h"
#include "core/source.h"
#include "daemon/config.h"

namespace roseau::daemon {

struct Sources {
  std::vector<std::unique_ptr<SampleSource>> sources;
  std::vector<std::string> cameras;                   // devices whose frames are tracked
  std::map<std::string, ImageStorage> image_storage;  // by camera; where it is jpeg, its frames come in that form
  std::vector<OperatorAction> first_actions;          // targets that a scene knows of
};

/// Live sources for `run`. Errors name the file or key. Devices that are absent are no error here: the supervisor waits for
/// them.
Result<Sources> make_sources(const Config& config);

}  // namespace roseau::daemon
