// The times and the status of a recorded message, without its payload: for tools that count and move messages of any size.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/result.h"
#include "core/sample.h"

namespace roseau::schema {

/// Status, sequence and times in `message`, a message that carries samples of this kind. What it does not say is taken from
/// `known` (see parse() in conversion.h). Errors: corrupt or truncated.
Result<SampleHeader> read_header(SampleKind kind, std::span<const std::byte> message, const SampleHeader& known);

/// Appends to `message` what moves it to another host's time axis: its times become those of `corrected`, and the times it had,
/// `own`, are kept in its header as host_arrival_time and host_sample_time (SampleHeader.proto). Everything else stays as it
/// is: in protobuf a field that comes again replaces the one before.
void append_corrected_times(SampleKind kind, const SampleHeader& corrected, const SampleHeader& own,
                            std::vector<std::byte>& message);

}  // namespace roseau::schema
