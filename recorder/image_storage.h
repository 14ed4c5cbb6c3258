// How the recorder stores a frame: asked for by the configuration, else as the stream was stored where it comes from.
#pragma once

#include "core/sample.h"
#include "core/stream.h"
#include "recorder/recorder.h"

namespace roseau::recorder {

/// Raw for everything that is no frame.
ImageStorage storage_of(const Sample& sample, const StreamInfo& stream, const RecorderOptions& options);

/// The stream as its channel describes it: with that storage.
StreamInfo stored_stream(const Sample& sample, const StreamInfo& stream, const RecorderOptions& options);

}  // namespace roseau::recorder
