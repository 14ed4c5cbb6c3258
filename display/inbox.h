// Inbox: the bounded edge between the pipeline and the display's own thread. Handing a sample over never blocks for longer
// than a push into a list: of pictures only the newest of each stream waits, everything else waits in order up to a bound.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>

#include "core/sample.h"

namespace roseau::display {

/// Whether only the newest sample of a stream matters to a viewer: pictures, and the points drawn over them.
bool is_conflated(SampleKind kind);

struct InboxItem {
  Sample sample;
  HostTime log_time;
  std::uint64_t jump = 0;  // which of the replay's jumps it came after
};

/// Thread-safe: any number of producers, one consumer.
class Inbox {
 public:
  explicit Inbox(std::size_t capacity) : capacity_(capacity) {}

  /// False when the small messages' bound is reached: this one is dropped and counted. A picture is always taken; the one it
  /// replaces is counted.
  bool push(InboxItem item);

  /// The next item, waiting for one until `timeout`. Small messages first.
  std::optional<InboxItem> pop(std::chrono::milliseconds timeout);

  /// Forgets what waits, uncounted.
  void clear();

  /// Ends the waiting of pop(), now and for good.
  void close();

  /// For an item the consumer had to leave out.
  void count_drop(StreamId stream);

  /// Dropped or replaced so far, per stream.
  std::map<StreamId, std::uint64_t> dropped() const;

 private:
  std::optional<InboxItem> take();

  const std::size_t capacity_;
  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  std::deque<InboxItem> small_;
  std::map<StreamId, InboxItem> latest_;
  StreamId last_stream_ = 0;
  std::map<StreamId, std::uint64_t> dropped_;
  bool closed_ = false;
};

}  // namespace roseau::display
