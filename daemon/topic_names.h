// What the topics of targets say: "/camera0/target/branch/identification" is about the target "camera0/branch".
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace roseau::daemon {

/// The target's name in reports when `topic` ends in "/<last>": "camera0/branch" for tracked targets, "oak" for the imported
/// series "/displacement/oak". Nothing for any other topic.
std::optional<std::string> target_of_topic(std::string_view topic, std::string_view last);

}  // namespace roseau::daemon
