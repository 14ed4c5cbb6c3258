#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "daemon/commands.h"
#include "recorder/tools/selection/selection.h"

namespace roseau::daemon {

inline recorder::SelectionOptions selection_of(const PartArguments& part) {
  return {.from = part.from, .to = part.to, .seconds = part.seconds, .topics = part.topics, .without = part.without};
}

/// What of the source could not be read, on standard error: the result lacks it.
inline void warn_of_damage(const std::vector<std::string>& damage) {
  for (const auto& sentence : damage) std::fputs(("roseau: damaged: " + sentence + "\n").c_str(), stderr);
}

}  // namespace roseau::daemon
