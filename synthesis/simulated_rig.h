// SimulatedRig: a scene's devices as SampleSources: two cameras, a sonic, and the truth.
//
// Live: one source per device, each keeping real time against the caller's clock, as real devices do. Otherwise as fast as
// the consumer, in the scene's own time, where the same scene gives the same samples, byte for byte.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "core/emulated_instrument.h"
#include "core/source.h"
#include "synthesis/scene.h"

namespace roseau::synthesis {

class World;

/// How a live source sees real time. No clock is read in synthesis itself.
struct Pacing {
  std::function<HostTime()> now;
  std::function<void(Duration)> wait;  // sleeps that long; std::this_thread::sleep_for where it is empty
};

class SimulatedRig {
 public:
  /// When simulated time begins.
  static constexpr HostTime kSimulatedStart = host_time_from_ns(1'000'000'000);

  /// Takes a second or so. Error: what the scene cannot be: see World::build().
  static Result<SimulatedRig> create(const Scene& scene);

  /// "camera0", "camera1", "sonic", "truth": never ending; the scene starts now. A camera whose reader falls behind by more
  /// than half a second, or finds no free buffer, loses frames, as a real one does; the gap shows in their sequence. A source
  /// that is closed and opened again goes on where the scene then is.
  std::vector<std::unique_ptr<SampleSource>> live_sources(const Pacing& pacing) const;

  /// The same devices, `seconds` of the scene each, as fast as they are read.
  std::vector<std::unique_ptr<SampleSource>> sources(double seconds) const;

  /// The scene's instruments on serial lines, to be spoken to as the real ones: "sonic", "tracker", "led_board", as far as the
  /// scene has them. Thread rule of EmulatedInstrument, each by itself.
  std::vector<std::unique_ptr<EmulatedInstrument>> emulated_instruments() const;

  /// All devices as one source ("rig"), in order of arrival time.
  std::unique_ptr<SampleSource> merged_source(double seconds) const;

  /// What an operator would mark in the pictures: the scene's targets, in every camera.
  std::vector<OperatorAction> targets() const;

 private:
  explicit SimulatedRig(std::shared_ptr<const World> world) : world_(std::move(world)) {}

  std::shared_ptr<const World> world_;
};

/// Writes `seconds` of the rig to `sink`, all streams in order of arrival time, then flushes it. A sample that the sink
/// refuses is the sink's to count.
Result<void> simulate(const SimulatedRig& rig, double seconds, StreamTable& streams, SampleSink& sink);

}  // namespace roseau::synthesis
