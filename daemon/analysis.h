// Analysis: the ordered stream through tracking and estimation. Each camera is tracked by a thread of its own; results are
// joined again in the order of the stream, and estimation runs on the joined stream, so that the output is one order only,
// whatever the threads did.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/sample.h"
#include "core/stage.h"
#include "core/stream.h"

namespace roseau::daemon {

class Analysis {
 public:
  /// One camera's tracking: sees the samples of its device and every operator action.
  struct Tracker {
    std::string device;
    std::unique_ptr<Stage> stage;
  };
  /// Called in the join thread, in order: every sample submitted or derived. `log_time` is that of the input it came from.
  using Output = std::function<void(const Sample& sample, HostTime log_time)>;

  Analysis(const StreamTable& streams, std::vector<Tracker> trackers, std::unique_ptr<Stage> estimation, Output output,
           std::size_t capacity = 256);
  ~Analysis();

  /// Hands over the next sample of the ordered stream; waits while `capacity` samples are under way. One thread.
  void submit(Sample&& sample, HostTime log_time);

  /// Frames of this device submitted and not yet tracked: what the live skip policy looks at. Thread-safe.
  std::size_t frames_waiting(const std::string& device) const;

  /// Waits until everything submitted has come out, then ends the threads. Idempotent.
  void finish();

  /// Ends as soon as every thread has done what it has in hand: what else is under way does not come out.
  void abandon();

  /// CPU seconds used so far: tracking of each device ("tracking/camera0"), "estimation", "output". Thread-safe.
  std::vector<std::pair<std::string, double>> cpu_seconds() const;

 private:
  struct Slot {
    Sample sample;
    HostTime log_time;
    std::size_t pending = 0;                   // trackers that have not done their part yet
    std::vector<std::vector<Sample>> derived;  // by tracker
  };
  struct Worker {
    Tracker tracker;
    std::deque<std::size_t> todo;  // slot numbers, in order
    std::size_t frames = 0;
    double cpu_s = 0;
    std::jthread thread;
  };

  Slot& slot(std::size_t number) { return slots_[number % slots_.size()]; }
  bool concerns(const Worker& worker, const Sample& sample) const;
  void work(std::size_t index, const std::stop_token& stop);
  void join(const std::stop_token& stop);
  void emit(Slot& slot);
  void emit_one(const Sample& sample, HostTime log_time);

  const StreamTable& streams_;
  std::unique_ptr<Stage> estimation_;
  Output output_;

  mutable std::mutex mutex_;
  std::condition_variable space_;
  std::condition_variable_any work_ready_;
  std::condition_variable_any slot_done_;
  std::vector<Slot> slots_;
  std::size_t submitted_ = 0;
  std::size_t joined_ = 0;
  double estimation_cpu_s_ = 0;
  double output_cpu_s_ = 0;
  std::atomic<bool> abandoned_{false};
  std::vector<std::unique_ptr<Worker>> workers_;
  std::jthread join_thread_;
};

}  // namespace roseau::daemon
