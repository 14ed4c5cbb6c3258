// SimulatedDevice: what one device of the rig sends, in order, in the scene's own time. Knows nothing of pacing: a
// SampleSource around it (simulated_rig.h) decides when to ask.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "core/source.h"
#include "core/time.h"
#include "synthesis/random.h"
#include "synthesis/scene.h"

namespace roseau::synthesis {

/// When a device's next sample reaches the host, since the scene's start.
struct Due {
  Duration arrival{0};   // its first byte, or its frame: the sample's arrival time
  Duration complete{0};  // its last byte: before that nobody has it
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
};

/// Times of a device that samples at a steady rate on its own clock.
class SampleTimes {
 public:
  SampleTimes(double rate_hz, const DeviceTiming& timing, std::uint64_t seed, std::uint64_t stream)
      : interval_s_(1 / (rate_hz * (1 + timing.frequency_offset_ppm * 1e-6))), timing_(timing), delays_(seed, stream) {}

  double sample_time_s(std::uint64_t number) const {
    return timing_.start_offset_s + static_cast<double>(number) * interval_s_;
  }

  /// From the sample time to the arrival.
  double delay_s(std::uint64_t number) const {
    return timing_.latency_s - timing_.jitter_s * std::log(delays_.uniform(number));
  }

  /// First sample whose time is not before this.
  std::uint64_t first_from(double time_s) const {
    return static_cast<std::uint64_t>(std::max(0.0, std::ceil((time_s - timing_.start_offset_s) / interval_s_)));
  }

 private:
  double interval_s_;
  DeviceTiming timing_;
  RandomStream delays_;
};

}  // namespace roseau::synthesis
