// Queue: what the recorder's callers and its writer thread share: samples on their way, counters, and the state everyone may
// ask for.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
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
};

class Queue {
 public:
  explicit Queue(std::uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}

  /// A new file: counters and state begin anew, samples are taken.
  void begin(const std::string& path);

  /// Callers' side; see Recorder::record.
  bool push(const Sample& sample, HostTime log_time, bool wait_when_full);

  /// Writer's side: everything queued, in order, into `batch` (replaced); waits for something until `deadline`. False: the file
  /// is being closed, and this was the last.
  bool pop(std::vector<QueuedSample>& batch, std::chrono::steady_clock::time_point deadline);
  /// A caller waits for space: what is held in unfilled chunks should be written now.
  bool callers_wait() const;
  /// Makes the writer's pop return at once and for the last time; further samples are ignored.
  void begin_closing();

  /// Writer's side: what was written or lost.
  void settle(const Written& written, std::uint64_t file_bytes);
  /// The first failure of a write: stays, and everything queued or still coming is dropped.
  void fail(const Error& error);
  bool has_failed() const;
  void end(DeviceState state, const std::string& message);
  void set_disk_free(std::uint64_t bytes);

  /// Drops since the last call, by stream.
  std::vector<std::pair<StreamId, std::uint64_t>> take_new_drops();
  HostTime last_log_time() const;
  std::optional<Error> first_error() const;
  RecorderState state(const StreamTable& streams) const;

 private:
  struct Counts {
    std::uint64_t received = 0;
    std::uint64_t recorded = 0;
    std::uint64_t dropped = 0;
    std::uint64_t dropped_reported = 0;
  };
  Counts& counts_of(StreamId stream);
  void drop(StreamId stream, std::uint64_t count);
  void wake_writer();

  const std::uint64_t budget_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable work_ready_;
  std::condition_variable space_ready_;
  bool taking_ = false;
  bool closing_ = false;
  bool writer_waits_ = false;
  int waiting_callers_ = 0;
  std::vector<QueuedSample> samples_;
  std::uint64_t held_bytes_ = 0;  // queued, or in a chunk that is not written yet
  std::vector<Counts> counts_;    // by stream
  std::optional<Error> first_error_;
  bool write_failed_ = false;
  RecorderState state_;  // all but `streams`, `seconds`
  std::optional<HostTime> first_log_time_;
  HostTime last_log_time_{Duration{0}};
};

}  // namespace roseau::recorder
