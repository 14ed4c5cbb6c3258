// What decoders and their streams say to each other through a stream's metadata.
#pragma once

#include <string>
#include <string_view>

#include "core/sample.h"
#include "core/stream.h"

namespace roseau::wire {

inline constexpr std::string_view kRawSuffix = "/raw";

/// The value of a metadata key; empty where it is absent.
std::string_view metadata_value(const StreamInfo& info, const std::string& key);

/// The number that a metadata key holds; `fallback` where there is none.
double metadata_number(const StreamInfo& info, const std::string& key, double fallback);

/// A stream derived from a raw one: "/sonic/raw" and "wind" give "/sonic/wind", with the raw stream's metadata except what
/// only concerns its bytes.
StreamInfo derived_stream(const StreamInfo& raw, std::string_view suffix, SampleKind kind);

}  // namespace roseau::wire
