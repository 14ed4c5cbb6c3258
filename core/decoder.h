// Decoder: bytes with arrival times in, samples out. Pure: the same inputs give the same outputs, live and in replay.
// Runs in the sequencer's thread, behind the point where the raw bytes are recorded.
#pragma once

#include "core/sample.h"
#include "core/source.h"

namespace roseau {

struct DecoderCounters {
  std::uint64_t records = 0;        // good records handed on
  std::uint64_t bad_records = 0;    // recognised but wrong: checksum, field, range
  std::uint64_t skipped_bytes = 0;  // belonged to no good record
  std::uint64_t text_lines = 0;     // lines of text that are no records: power-up banner, echo of commands
};

class Decoder {
 public:
  virtual ~Decoder() = default;
  /// Feeds one RawBytes sample of this decoder's stream; every record completed by it goes to `sink`, stamped with the
  /// arrival time of its own first byte.
  virtual void decode(const Sample& raw, SampleSink& sink) = 0;
  /// Forgets a partly received record (the device was reopened).
  virtual void reset() = 0;
  virtual const DecoderCounters& counters() const = 0;
};

}  // namespace roseau
