#include "drivers/wire/metadata.h"

#include <charconv>

namespace roseau::wire {

std::string_view metadata_value(const StreamInfo& info, const std::string& key) {
  const auto found = info.metadata.find(key);
  return found == info.metadata.end() ? std::string_view() : found->second;
}

double metadata_number(const StreamInfo& info, const std::string& key, double fallback) {
  const auto text = metadata_value(info, key);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? value : fallback;
}

StreamInfo derived_stream(const StreamInfo& raw, std::string_view suffix, SampleKind kind) {
  StreamInfo derived = raw;
  if (derived.topic.ends_with(kRawSuffix)) derived.topic.resize(derived.topic.size() - kRawSuffix.size());
  derived.topic += "/" + std::string(suffix);
  derived.kind = to_string(kind);
  derived.role = StreamRole::derived;
  derived.metadata.erase("framing");
  derived.metadata.erase("link");
  return derived;
}

}  // namespace roseau::wire
