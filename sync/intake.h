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
  void drop(StreamId stream, std::uint64_t count) override;
  /// Of sources that may wait: returns when everything received so far is taken and passed on.
  void flush() override;
  /// Of sources that may wait: what is received from now on has nothing to do with what was received before; returns when
  /// the consumer is ready for it. `discard`: what has not been taken yet is not wanted any more.
  void restart(bool discard);
  /// Whether flush() or restart() waits for the consumer.
  bool is_asking() const { return request_.load() != Request::none; }
  /// The source has ended: nothing more will come.
  void finish();

 private:
  friend class Intake;
  enum class Request : std::uint8_t { none, flush, restart, discard_and_restart };
  bool wait_for_space();
  void request(Request request);

  Intake& intake_;
  const bool live_;
  SpscRing<Sample> ring_;
  std::optional<Sample> head_;  // consumer's side: taken from the ring, not yet merged
  std::atomic<bool> finished_{false};
  std::atomic<Request> request_{Request::none};  // waited for by the producer until the consumer has set it back
};

class Intake {
 public:
  explicit Intake(CounterTable& counters) : counters_(counters) {}

  /// Before run(). The inlet stays valid for the intake's life.
  Inlet& add_inlet(bool live, std::size_t capacity);

  struct Callbacks {
    std::function<void(Sample)> take;
    std::function<void()> idle;  // nothing came for a while
    std::function<void()> flush = [] {};
    std::function<void(bool discard)> restart = [](bool /*discard*/) {};
  };

  /// In the sequencer's thread: hands over every sample in order of arrival time, as far as it is known at that moment,
  /// until all inlets have finished and are empty, or `stop` is requested.
  void run(const std::stop_token& stop, const Callbacks& callbacks);

  /// Ends every wait: producers waiting for space give up. Called when the pipeline shuts down.
  void close();

 private:
  friend class Inlet;
  struct Merge {
    Inlet* earliest = nullptr;
    Inlet* asking = nullptr;  // everything it gave is taken, or not wanted: its request is due
    bool all_done = true;
    bool must_wait = false;  // a source that is not live may still have something earlier
  };
  Merge look();
  static void discard(Inlet& inlet);
  void carry_out(Inlet& inlet, const Callbacks& callbacks);
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
