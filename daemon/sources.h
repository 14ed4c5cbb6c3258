// From the configuration to sample sources: devices, or the simulated rig in their place.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/sample.h"
#include "core/source.h"
#include "daemon/config.h"
#include "synthesis/scene.h"

namespace roseau::daemon {

struct Sources {
  std::vector<std::unique_ptr<SampleSource>> sources;
  std::vector<std::string> cameras;           // devices whose frames are tracked
  std::vector<OperatorAction> first_actions;  // targets that a scene knows of
};

/// Live sources for `run`. Errors name the file or key. Devices that are absent are no error here: the supervisor waits for
/// them.
Result<Sources> make_sources(const Config& config);

/// The scene of a file, or the built-in demo scene when `path` is empty.
Result<synthesis::Scene> load_scene(const std::filesystem::path& path, std::optional<std::uint64_t> seed);

/// The configuration that a simulated session carries, for its replay: what is known of the scene and no operator need say.
std::string scene_config_text();

/// One target per camera: the branch of the scene, where it is at the mean wind.
std::vector<OperatorAction> scene_targets(const synthesis::Scene& scene);

}  // namespace roseau::daemon
