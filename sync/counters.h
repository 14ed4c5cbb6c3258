// Counters of every stream, written by any thread, read by the control loop. Counting never blocks and never allocates after
// a stream's first sample.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <mutex>

#include "core/sample.h"
#include "core/stream.h"

namespace roseau::sync {

struct StreamCounts {
  std::atomic<std::uint64_t> received{0};
  std::atomic<std::uint64_t> recorded{0};
  std::atomic<std::uint64_t> dropped{0};
  std::atomic<std::uint64_t> dropped_intake{0};  // of those: before the sequencer, whose ring was full
  std::atomic<std::uint64_t> gaps{0};
  std::atomic<std::uint64_t> bad{0};
  std::atomic<std::uint64_t> late{0};
  std::atomic<std::int64_t> last_arrival_ns{0};

  StreamCounters snapshot() const {
    return {.received = received.load(),
            .recorded = recorded.load(),
            .dropped = dropped.load(),
            .gaps = gaps.load(),
            .bad = bad.load(),
            .late = late.load(),
            .dropped_intake = dropped_intake.load()};
  }
};

class CounterTable {
 public:
  /// The reference stays valid for the table's life.
  StreamCounts& of(StreamId stream) {
    const std::scoped_lock lock(mutex_);
    while (counts_.size() <= stream) counts_.emplace_back();
    return counts_[stream];
  }
  std::size_t size() const {
    const std::scoped_lock lock(mutex_);
    return counts_.size();
  }

 private:
  mutable std::mutex mutex_;
  std::deque<StreamCounts> counts_;
};

}  // namespace roseau::sync
