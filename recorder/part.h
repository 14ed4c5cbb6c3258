// Part: one file of a recording with everything that belongs to it alone, so that another thread can finish it while the next
// one is written. One thread at a time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "recorder/format/io.h"
#include "recorder/queue.h"
#include "recorder/recorder.h"
#include "recorder/session_writer.h"

namespace roseau::recorder {

/// Where all counters stood at one moment.
struct CountsSnapshot {
  std::vector<StageCounts> stages;  // by stream
  mcap::TopicCounters upstream;     // kept by others
};

class Part {
 public:
  /// What happened before `begin` is no matter of this file.
  Part(std::unique_ptr<mcap::Writable> out, std::filesystem::path path, StreamTable& streams, const RecorderOptions& options,
       Queue& queue, CountsSnapshot begin);

  Result<void> write_head(const SessionDescription& description, PartHead head);

  /// A sample that came by the queue, or one of the recorder's own.
  Result<void> add(const QueuedSample& queued);
  Result<void> flush() { return session_.flush(); }
  Result<void> flush_older();
  /// Counters as of now; nothing when they have not changed since the last.
  /// `earlier`: of all earlier parts.
  Result<void> checkpoint(const CountsSnapshot& now, const mcap::TopicCounters& earlier);
  Result<void> begin_sync() { return out_->begin_sync(); }
  /// After a failure: what is not written is lost.
  void abandon();
  /// Tells the queue what was written or lost since it was last told, and gives back its space.
  void settle();

  /// Everything into the file, its end, closed. Errors are in `problem`, and what was lost by them has been settled.
  /// `end`: as the counters stood when the next part began. `session`: of all earlier parts; this one's are added.
  FinishedPart finish(const CountsSnapshot& end, mcap::TopicCounters& session);

  bool has_samples() const { return first_log_time_.has_value(); }
  std::uint64_t bytes() const { return session_.bytes(); }
  /// Of those, what the file has got: another program can read them.
  std::uint64_t written_bytes() const { return std::min(session_.bytes(), out_->written()); }
  std::uint64_t bytes_with(const Sample& sample) { return session_.bytes_with(sample); }
  /// Of log time since the part's first sample.
  Duration age_at(HostTime log_time) const;
  const std::filesystem::path& path() const { return path_; }
  std::uint32_t number() const { return head_.part; }
  mcap::TopicCounters counters(const CountsSnapshot& now, bool with_queue) const;

 private:
  struct Counts {
    std::uint64_t taken = 0;
    std::uint64_t recorded = 0;
    std::uint64_t dropped_write = 0;
    std::uint64_t dropped_encoder = 0;
    std::uint64_t repeated = 0;
    std::uint64_t repeats_open = 0;  // of those, neither written nor lost yet
  };
  Counts& counts_of(StreamId stream);
  void take_out_repeats(std::map<StreamId, std::uint64_t>& settled, std::uint64_t Counts::*counter);

  std::unique_ptr<mcap::Writable> out_;
  std::filesystem::path path_;
  StreamTable& streams_;
  Queue& queue_;
  const CountsSnapshot begin_;
  PartHead head_;
  SessionWriter session_;
  std::vector<Counts> counts_;  // by stream
  std::optional<HostTime> first_log_time_;
  HostTime last_log_time_;
  std::optional<mcap::Metadata> last_checkpoint_;
  bool failed_ = false;
};

}  // namespace roseau::recorder
