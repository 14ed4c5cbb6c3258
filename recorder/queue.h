// Queue: what the recorder's callers and its writer thread share: samples on their way, counters, and the state everyone may
// ask for.
//
// Callers are capture threads, which must not be held up by whoever else runs or waits: push() takes no lock, allocates nothing
// of its own (the copy of a sample with vectors in it does; frames are shared), and makes no system call as long as the queue
// is not a quarter full: the writer looks by itself every few milliseconds. It is a ring of slots that callers claim by one
// compare-and-swap each (D. Vyukov's bounded queue) and that the one writer empties in order. Only who asked to wait for space
// takes a lock.
#pragma once

#include <semaphore.h>

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/sample.h"
#include "core/stream.h"
#include "core/time.h"
#include "recorder/recorder.h"
#include "recorder/session_writer.h"

namespace roseau::recorder {

struct QueuedSample {
  Sample sample;
  HostTime log_time;
  std::uint64_t bytes = 0;
  std::uint64_t position = 0;  // the how manieth since begin()
};

/// One stream's samples on their way. Received = dropped_queue + refused + taken + those in the queue now.
struct StageCounts {
  std::uint64_t received = 0;
  std::uint64_t dropped_queue = 0;    // it was full
  std::uint64_t refused = 0;          // came after a write had failed
  std::uint64_t taken = 0;            // by the writer thread
  std::uint64_t recorded = 0;         // of those
  std::uint64_t dropped_write = 0;    // of those
  std::uint64_t dropped_encoder = 0;  // of those

  std::uint64_t in_queue() const { return received - dropped_queue - refused - taken; }
  std::uint64_t dropped() const { return dropped_queue + refused + dropped_write + dropped_encoder; }
};

class Queue {
 public:
  explicit Queue(std::uint64_t budget_bytes);
  ~Queue();
  Queue(const Queue&) = delete;
  Queue& operator=(const Queue&) = delete;

  /// A new recording: counters and state begin anew, samples are taken.
  void begin(const std::string& path, const std::string& session_id, std::uint32_t part);

  /// Callers' side; see Recorder::record.
  bool push(const Sample& sample, HostTime log_time, bool wait_when_full);
  /// Samples pushed from now on (as seen by this thread) have at least this position.
  std::uint64_t next_position() const { return tail_.load(); }

  /// Writer's side: what is queued, in order, into `batch` (replaced); waits for something, a few milliseconds or until
  /// `deadline`. False: the recording is being closed, and this was the last.
  bool pop(std::vector<QueuedSample>& batch, std::chrono::steady_clock::time_point deadline);
  /// A caller waits for space: what is held in unfilled chunks should be written now.
  bool callers_wait() const { return waiting_callers_.load() > 0; }
  /// Makes the writer's pop return at once and, when all is fetched, for the last time; further samples are ignored.
  void begin_closing();

  /// What was written or lost. The writer's and the finishing thread.
  void settle(const Written& written);
  /// A sample of the recorder's own, that did not come by push.
  void count_own(StreamId stream);

  /// The first failure of a write: stays, and everything queued or still coming is dropped.
  void fail(const Error& error);
  /// A failure that lost something and is no reason to stop.
  void report(const Error& error);
  void end(DeviceState state, const std::string& message);

  /// For the state.
  void set_disk_free(std::uint64_t bytes);
  void set_bytes(std::uint64_t file, std::uint64_t session);
  void set_seconds(double seconds);
  void set_part(const std::string& path, std::uint32_t part);
  void set_parts_finishing(std::uint32_t count);
  void set_split_problem(const std::string& problem);

  /// By stream; each is seen at a slightly different moment.
  std::vector<StageCounts> counts() const;
  std::optional<Error> first_error() const;
  bool is_taking() const { return taking_.load(); }
  RecorderState state(const StreamTable& streams) const;

 private:
  struct Slot {
    std::atomic<std::uint64_t> turn{0};  // = position: free for it; position + 1: filled
    QueuedSample value;
  };
  struct AtomicCounts {
    std::atomic<std::uint64_t> received{0};
    std::atomic<std::uint64_t> dropped_queue{0};
    std::atomic<std::uint64_t> refused{0};
    std::atomic<std::uint64_t> taken{0};
    std::atomic<std::uint64_t> recorded{0};
    std::atomic<std::uint64_t> dropped_write{0};
    std::atomic<std::uint64_t> dropped_encoder{0};
  };
  static constexpr std::size_t kStreamsPerBlock = 64;
  using CountsBlock = std::array<AtomicCounts, kStreamsPerBlock>;
  static constexpr std::size_t kBlocks = (std::size_t{std::numeric_limits<StreamId>::max()} + 1) / kStreamsPerBlock;

  AtomicCounts& counts_of(StreamId stream);
  bool reserve(std::uint64_t bytes);
  Slot* claim(std::uint64_t& position);
  Slot* enter(std::uint64_t bytes, std::uint64_t& position);
  Slot* wait_to_enter(std::uint64_t bytes, std::uint64_t& position);
  bool refuse(StreamId stream);
  void wake_writer();
  void give_space_back(std::uint64_t bytes);
  bool has_filled_slot() const;

  const std::uint64_t budget_bytes_;
  const std::size_t slot_count_;   // a power of two
  std::unique_ptr<Slot[]> slots_;  // made by the first begin()

  // Each group is written by other threads: lines of their own, so that they do not slow each other down.
  alignas(64) std::atomic<std::uint64_t> tail_{0};        // next position to claim
  alignas(64) std::atomic<std::uint64_t> held_bytes_{0};  // queued, or in a chunk that is not written yet
  alignas(64) std::atomic<int> callers_inside_{0};
  std::atomic<bool> taking_{false};
  std::atomic<bool> write_failed_{false};
  std::atomic<int> waiting_callers_{0};
  std::atomic<bool> writer_waits_{false};
  std::atomic<bool> closing_{false};
  std::atomic<bool> was_full_{false};
  alignas(64) std::uint64_t head_ = 0;  // next position to fetch; the writer's alone
  sem_t work_ready_;

  std::mutex space_mutex_;
  std::condition_variable space_ready_;

  std::array<std::atomic<CountsBlock*>, kBlocks> counts_{};

  mutable std::mutex state_mutex_;
  std::optional<Error> first_error_;
  RecorderState state_;  // all but `streams`
};

}  // namespace roseau::recorder
