// SimulatedDevice: what one device of the rig sends, in order, in the scene's own time. Knows nothing of pacing: a
// SampleSource around it (simulated_rig.h) decides when to ask.
#pragma once

#include <optional>
#include <string>

#include "core/result.h"
#include "core/source.h"
#include "core/time.h"

namespace roseau::synthesis {

/// When a device's next sample reaches the host, since the scene's start.
struct Due {
  Duration arrival{0};   // its first byte, or its frame: the sample's arrival time
  Duration complete{0};  // its last byte: before that nobody has it

  /// Of a device that has nothing more to send.
  static constexpr Due never() { return {Duration::max() / 4, Duration::max() / 4}; }
};

/// One thread at a time.
class SimulatedDevice {
 public:
  virtual ~SimulatedDevice() = default;
  virtual const std::string& name() const = 0;

  /// Adds its streams. Always the same ones.
  virtual void declare(StreamTable& streams) = 0;

  /// Arrivals never go back.
  virtual Due next() const = 0;

  /// Hands what is due next to `sink`, the scene having started at `start`, and goes on to what comes after. False: it could
  /// not, for want of a free frame buffer; asking again later gives the same sample.
  virtual bool produce(HostTime start, SampleSink& sink) = 0;

  /// A live device whose reader stalled: forgets what nobody fetched in time, as the real one would.
  virtual void lose_before(Duration time) = 0;

  /// Forgets the next sample: there was no buffer for it.
  virtual void lose_next() = 0;

  /// A live device is connected to at this time: what it sent before is lost.
  virtual void connect_at(Duration time) { lose_before(time); }

  /// What a driver would say at this time: the cable is pulled. Nothing while it is there.
  virtual std::optional<Error> fault_at(Duration /*time*/) const { return std::nullopt; }
};

}  // namespace roseau::synthesis
