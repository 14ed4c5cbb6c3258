// A scene's file, with the other files that it names: a digitised or scanned tree, a recorded wind.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/result.h"
#include "synthesis/scene.h"

namespace roseau::daemon {

/// The scene of a file, or the built-in demo scene when `path` is empty; files that it names are relative to it. A seed given
/// here takes the place of the scene's.
Result<synthesis::Scene> load_scene(const std::filesystem::path& path, std::optional<std::uint64_t> seed);

/// The configuration that a simulated session carries, for its replay: what is known of the scene and no operator need say.
std::string scene_config_text();

}  // namespace roseau::daemon
