// Finisher: gives parts of a recording their end, in order, in a thread of its own: the summary, the last sync and whatever is
// done with finished files take time that the samples of the next part do not have.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "recorder/part.h"

namespace roseau::recorder {

class Finisher {
 public:
  Finisher(Queue& queue, std::function<void(const FinishedPart&)> finished) : queue_(queue), finished_(std::move(finished)) {}
  /// Finishes what it was given.
  ~Finisher() { drain(); }
  Finisher(const Finisher&) = delete;
  Finisher& operator=(const Finisher&) = delete;

  /// `end`: as the counters stood when the next part began.
  void add(std::unique_ptr<Part> part, CountsSnapshot end);
  /// Waits for all parts, then finishes this one in the caller's thread.
  FinishedPart finish_last(Part& part, const CountsSnapshot& end);

  /// Of all parts that were given an end so far.
  mcap::TopicCounters session_counters() const;
  std::uint64_t session_bytes() const;

 private:
  struct Work {
    std::unique_ptr<Part> part;
    CountsSnapshot end;
  };
  void run();
  FinishedPart finish(Part& part, const CountsSnapshot& end, bool last);
  void drain();

  Queue& queue_;
  const std::function<void(const FinishedPart&)> finished_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Work> work_;
  bool ending_ = false;
  mcap::TopicCounters session_;
  std::uint64_t session_bytes_ = 0;
  std::jthread thread_;  // started by the first add()
};

}  // namespace roseau::recorder
