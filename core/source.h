// The one seam between where samples come from and what is done with them: live device, recorded session and simulated rig
// are all SampleSources; the sequencer, the recorder and the tests are SampleSinks.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "core/result.h"
#include "core/sample.h"
#include "core/stream.h"

namespace roseau {

class SampleSink {
 public:
  virtual ~SampleSink() = default;
  /// Takes the sample. False: it was dropped because this sink is full (the sink has counted it).
  virtual bool receive(Sample sample) = 0;
  /// Samples of this stream had to be thrown away on their way here: the sink counts them.
  virtual void drop(StreamId /*stream*/, std::uint64_t /*count*/) {}
  /// No more samples are coming, or not for a long while: pass on whatever is held back.
  virtual void flush() {}
};

enum class ReadStatus {
  more,      // something was delivered; call again
  idle,      // nothing came within the timeout
  finished,  // the source has ended (end of a file); never returned by a live device
  // Of recordings alone: what follows does not continue what came before, so that everything behind it starts anew.
  jumped,       // somebody wants to see another time; what is still under way no longer matters
  round_ended,  // the recording starts over; what came before is whole
};

/// One device (or one whole recorded session). Used by one thread at a time: the supervisor's thread for that device calls
/// open, then read until it fails or finishes, then close; after a failure it backs off and opens again.
class SampleSource {
 public:
  virtual ~SampleSource() = default;

  /// Short name, unique in a configuration: "camera0", "sonic".
  virtual const std::string& name() const = 0;

  /// A live source keeps real time by itself and must never be blocked; any other may wait for its consumer.
  virtual bool is_live() const = 0;

  /// Connects and declares its streams in `streams`. Opening twice declares the same topics.
  virtual Result<void> open(StreamTable& streams) = 0;

  /// Waits at most `timeout` for data, then hands what has come to `sink`. An Error means that the device is lost: bad data
  /// is a sample status instead. Timeouts stay <= 100 ms, which bounds how long a shutdown takes.
  virtual Result<ReadStatus> read(SampleSink& sink, std::chrono::milliseconds timeout) = 0;

  virtual void close() = 0;
};

}  // namespace roseau
