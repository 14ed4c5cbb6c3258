// ImageCoder: makes PNGs of the frames that are to be stored so, on threads of its own, while everything stays in its order.
//
//   writer thread: submit(sample) -> coding threads, for frames only -> take(): the samples in the order they were submitted
//
// It stands between the recorder's queue and its chunks: coding is lossless, so nobody else needs to wait for it, and while
// nothing is recorded it costs nothing. A frame's pixels are let go as soon as it is coded. The result does not depend on which
// thread did what.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "core/frame.h"
#include "core/result.h"
#include "recorder/queue.h"

namespace roseau::recorder {

/// Half of the machine's CPUs, 1 to 4: one codes a gigabyte of pixels per second, and tracking wants the others.
std::size_t default_coding_threads();

/// submit, take and empty by one thread.
class ImageCoder {
 public:
  /// Threads are started with the first frame.
  explicit ImageCoder(std::size_t threads = default_coding_threads());
  ~ImageCoder();  // what was not taken is lost
  ImageCoder(const ImageCoder&) = delete;
  ImageCoder& operator=(const ImageCoder&) = delete;

  /// `to_png`: the sample is a frame without a stored form, to be coded.
  void submit(QueuedSample queued, bool to_png);

  struct Done {
    QueuedSample queued;
    std::optional<Error> error;  // a frame that could not be coded: lost
  };
  /// The oldest sample, when it is ready before `deadline`. Nothing when it is not, and when there is none.
  std::optional<Done> take(std::chrono::steady_clock::time_point deadline);
  bool empty() const { return jobs_begin_ == jobs_end_; }

 private:
  struct Job {
    Done done;
    bool ready = false;
  };
  void code_until_stopped();
  FrameLease buffer_for(const Frame& frame);

  const std::size_t thread_count_;
  std::mutex mutex_;
  std::condition_variable work_ready_;
  std::condition_variable done_ready_;
  std::deque<Job> jobs_;             // numbered from jobs_begin_
  std::deque<std::size_t> to_code_;  // numbers of jobs that wait for a thread
  std::size_t jobs_begin_ = 0;
  std::size_t jobs_end_ = 0;
  bool stopping_ = false;
  std::unique_ptr<FramePool> buffers_;
  std::vector<std::jthread> threads_;
};

}  // namespace roseau::recorder
