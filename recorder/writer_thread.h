// WriterThread: takes samples out of the queue and writes them, part after part, until the recording is closed.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "recorder/finisher.h"
#include "recorder/image_coder.h"
#include "recorder/part.h"
#include "recorder/queue.h"
#include "recorder/recorder.h"

namespace roseau::recorder {

class WriterThread {
 public:
  WriterThread(StreamTable& streams, const RecorderOptions& options, Queue& queue);
  ~WriterThread() { join(); }
  WriterThread(const WriterThread&) = delete;
  WriterThread& operator=(const WriterThread&) = delete;

  /// Writes the head of the first part, and starts. Samples are taken from then on.
  Result<void> begin(std::unique_ptr<mcap::Writable> out, const std::filesystem::path& path,
                     const SessionDescription& description);
  /// The next part begins with the first sample that the calling thread pushes from now on.
  void split_now();
  /// After Queue::begin_closing.
  void join();

 private:
  using SteadyTime = std::chrono::steady_clock::time_point;

  void run();
  void write_until_closed();
  void code(QueuedSample queued);
  void take_coded(SteadyTime deadline);
  void add(const QueuedSample& queued);
  void settle();
  template <class Write>
  void attempt(Write write);
  void fail(const Error& error);
  void sync();
  void write_everything();
  void report_drops();
  void look_at_disk();
  void finish();

  void forget_marks(std::uint64_t up_to);
  bool split_is_due(const QueuedSample& next);
  void begin_next_part(const QueuedSample& first);
  Result<std::unique_ptr<Part>> make_next_part(const CountsSnapshot& begin, HostTime log_time);
  void split_failed(const Error& error);
  void remember_for_next_part(const Sample& sample);
  std::vector<Sample> repeats(HostTime log_time) const;
  CountsSnapshot counts() const;

  StreamTable& streams_;
  const RecorderOptions& options_;
  Queue& queue_;
  SessionDescription description_;
  std::string session_id_;
  std::filesystem::path first_path_;
  std::unique_ptr<Part> part_;
  Finisher finisher_;
  ImageCoder coder_;

  std::mutex marks_mutex_;
  std::deque<std::uint64_t> marks_;  // positions before which a part was asked to begin, in order
  static constexpr std::uint64_t kNoSplit = std::numeric_limits<std::uint64_t>::max();
  std::atomic<std::uint64_t> split_from_{kNoSplit};  // the first of them: so that no sample costs a lock
  SteadyTime no_split_before_{};                     // after a failure it is tried again, not at every sample
  bool split_failed_ = false;
  std::map<StreamId, Sample> calibrations_;                        // the latest
  std::map<std::pair<std::string, std::string>, Sample> targets_;  // by camera and name

  bool failed_ = false;
  std::uint64_t settled_bytes_ = 0;
  std::uint64_t earlier_bytes_ = 0;            // of the parts before this one
  std::vector<std::uint64_t> reported_drops_;  // by stream
  std::uint32_t drop_sequence_ = 0;
  std::optional<HostTime> first_log_time_;
  HostTime last_log_time_{Duration{0}};
  std::jthread thread_;
};

}  // namespace roseau::recorder
