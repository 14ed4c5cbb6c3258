#include "daemon/topic_names.h"

namespace roseau::daemon {

std::optional<std::string> target_of_topic(std::string_view topic, std::string_view last) {
  const std::string ending = "/" + std::string(last);
  constexpr std::string_view kImported = "/displacement/";
  constexpr std::string_view kTarget = "/target/";
  if (topic.size() <= ending.size() || !topic.ends_with(ending)) return std::nullopt;
  const std::string_view stem = topic.substr(0, topic.size() - ending.size());
  if (stem.starts_with(kImported)) return std::string(stem.substr(kImported.size()));
  const auto split = stem.find(kTarget);
  if (!stem.starts_with('/') || split == std::string_view::npos || split == 0) return std::nullopt;
  return std::string(stem.substr(1, split - 1)) + "/" + std::string(stem.substr(split + kTarget.size()));
}

}  // namespace roseau::daemon
