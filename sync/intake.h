// Intake: where the threads of all devices meet the sequencer's one thread. One bounded ring per source, merged by arrival
// time.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>

#include "core/sample.h"
#include "core/source.h"
#include "core/spsc_ring.h"
#include "sync/counters.h"

namespace roseau::sync {

class Intake;

/// One source's way in. receive() by the source's thread only.
///
/// A live source is never blocked: when the ring is full the new sample is dropped and counted. Any other source waits.
class Inlet : public SampleSink {
 public:
  Inlet(Intake& intake, bool live, std::size_t capacity);
  bool receive(Sample sample) override;
  /// The source has ended: nothing more will come.
  void finish();

 private:
  friend class Intake;
  bool wait_for_space();

  Intake& intake_;
  const bool live_;
  SpscRing<Sample> ring_;
  std::optional<Sample> head_;  // consumer's side: taken from the ring, not yet merged
  std::atomic<bool> finished_{false};
};

class Intake {
 public:
  explicit Intake(CounterTable& counters) : counters_(counters) {}

  /// Before run(). The inlet stays valid for the intake's life.
  Inlet& add_inlet(bool live, std::size_t capacity);

  /// In the sequencer's thread: hands over every sample in order of arrival time, as far as it is known at that moment,
  /// until all inlets have finished and are empty, or `stop` is requested. `idle` is called whenever nothing came for a while.
  void run(const std::stop_token& stop, const std::function<void(Sample)>& take, const std::function<void()>& idle);

  /// Ends every wait: producers waiting for space give up. Called when the pipeline shuts down.
  void close();

 private:
  friend class Inlet;
  struct Merge {
    Inlet* earliest = nullptr;
    bool all_done = true;
    bool must_wait = false;  // a source that is not live may still have something earlier
  };
  Merge look();
  void wait_for_samples();
  void wake_consumer();

  CounterTable& counters_;
  std::deque<Inlet> inlets_;
  std::mutex mutex_;
  std::condition_variable samples_ready_;
  std::condition_variable space_ready_;
  std::atomic<bool> consumer_waits_{false};
  std::atomic<int> producers_wait_{0};
  std::atomic<bool> closed_{false};
};

}  // namespace roseau::sync
