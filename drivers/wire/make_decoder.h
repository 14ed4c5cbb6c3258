// From a raw stream to its decoder: whatever the metadata key "model" names, live and in replay.
#pragma once

#include <memory>

#include "core/decoder.h"
#include "core/stream.h"

namespace roseau::wire {

/// Makes the decoder that a raw stream's metadata asks for (anemometer.h, trisonica.h, nmea0183.h, magnetic_tracker.h,
/// led_board.h) and adds the streams of its samples to `streams`, which must outlive it. Nothing when the model is absent or
/// none of ours: the bytes are then only recorded.
std::unique_ptr<Decoder> make_decoder(const StreamInfo& raw, StreamTable& streams);

}  // namespace roseau::wire
