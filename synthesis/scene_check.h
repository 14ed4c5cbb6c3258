// What can be wrong with a scene, said once, for scenes made in code and for scenes read from files.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "synthesis/scene.h"

namespace roseau::synthesis {

/// One thing that makes no sense: the key in its section ("wind", "branch", "camera", "sonic", "truth"; `camera` counts the
/// cameras) and what it must be.
struct SceneProblem {
  std::string_view section;
  std::size_t camera = 0;
  std::string_view key;
  std::string what;
};

void find_problems(const Scene& scene, const std::function<void(const SceneProblem&)>& report);

}  // namespace roseau::synthesis
