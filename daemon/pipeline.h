// Pipeline: sources -> intake -> sequencer -> analysis, with hooks where the recorder, the display, the digest and the
// summary listen. Owns the threads; knows nothing of files, sockets or configuration.
//
// Time never goes back in a sequencer or a stage. Where a recording jumps or starts over, both are made anew, as at the start
// of a run, while sources, counters and whoever listens live on: the same place gives the same results each time.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "core/sample.h"
#include "core/source.h"
#include "core/stage.h"
#include "core/stream.h"
#include "daemon/analysis.h"
#include "daemon/supervisor.h"
#include "sync/counters.h"
#include "sync/intake.h"
#include "sync/sequencer.h"

namespace roseau::daemon {

class Pipeline {
 public:
  /// What analyses; made at the start and again after every jump of a recording, in the sequencer's thread.
  struct Stages {
    std::vector<Analysis::Tracker> trackers;
    std::unique_ptr<Stage> estimation;
  };
  using StageFactory = std::function<Stages()>;

  struct Options {
    sync::Sequencer::Options sequencer;
    Supervisor::Options supervisor;
    std::size_t ring_capacity = 128;  // samples between each device's thread and the sequencer
    /// Live: a camera with this many frames waiting for its tracker has further ones skipped, together with the frames the
    /// other cameras took at the same time. 0 = never skip: wait.
    std::size_t skip_after_frames = 15;
    /// Replay: the frames skipped when this was recorded (topic, sequence): skipped again.
    std::set<std::pair<std::string, std::uint32_t>> recorded_skips;
  };

  /// All optional. They must not block for long: they run in the threads that they report on.
  struct Hooks {
    /// Sequencer's thread: every input as it is taken, in the order that is recorded.
    std::function<void(const Sample& sample, HostTime log_time)> input;
    /// Sequencer's thread: every frame in order of sample time, before and whether or not it is analysed.
    std::function<void(const Sample& sample, HostTime log_time)> frame;
    /// Analysis' thread: every sample but frames and raw bytes, in the one order that is the same in every replay.
    std::function<void(const Sample& sample, HostTime log_time)> analysed;
    /// Sequencer's thread, while no other hook runs: what comes next is a fresh start. `whole`: everything up to here has
    /// come out; otherwise the rest was thrown away.
    std::function<void(bool whole)> restarted;
  };

  Pipeline(Options options, StreamTable& streams, sync::Sequencer::DecoderFactory make_decoder, StageFactory make_stages,
           Hooks hooks);
  ~Pipeline();

  /// Before run().
  void add_source(std::unique_ptr<SampleSource> source);

  /// Puts an operator's action into the stream of inputs, stamped `now`. Thread-safe, while run() runs.
  void act(OperatorAction action, HostTime now);

  /// Runs in the calling thread until every source has ended or `stop` is requested; then everything taken in has come out.
  void run(const std::stop_token& stop);

  sync::CounterTable& counters() { return counters_; }
  const Supervisor& supervisor() const { return supervisor_; }
  /// As of the end of run(), or from a hook in the sequencer's thread.
  std::vector<ClockState> clocks() const { return sequencer_->clocks(); }
  /// The log time of the input taken last. Thread-safe.
  HostTime position() const { return host_time_from_ns(position_ns_.load(std::memory_order_relaxed)); }
  /// CPU seconds so far by part: "sequencer" (once run() has ended), the analysis' parts, "process" (everything, the
  /// recorder's and the display's threads included). Thread-safe.
  std::vector<std::pair<std::string, double>> cpu_seconds() const;

 private:
  std::unique_ptr<Analysis> make_analysis();
  std::unique_ptr<sync::Sequencer> make_sequencer();
  void take(Sample sample);
  void take_new_skips();
  void flush();
  void restart(bool discard);
  void on_ordered(Sample&& sample, HostTime log_time);
  bool is_skipped(const Sample& frame);

  Options options_;
  StreamTable& streams_;
  Hooks hooks_;
  sync::CounterTable counters_;
  sync::Intake intake_;
  Supervisor supervisor_;
  const sync::Sequencer::DecoderFactory make_decoder_;
  const StageFactory make_stages_;
  mutable std::mutex analysis_mutex_;  // of the pointer, which the sequencer's thread changes, and of what follows
  std::vector<std::pair<std::string, double>> earlier_cpu_s_;  // of analyses that have ended
  std::unique_ptr<Analysis> analysis_;
  std::unique_ptr<sync::Sequencer> sequencer_;

  std::mutex operator_mutex_;
  sync::Inlet* operator_inlet_ = nullptr;
  StreamId operator_stream_;
  std::uint32_t actions_ = 0;

  StreamId skip_stream_;
  std::vector<Sample> new_skips_;  // decided while the sequencer was giving out; taken as inputs right after
  std::uint32_t skips_ = 0;
  std::optional<HostTime> last_skipped_;
  std::atomic<std::int64_t> position_ns_{0};
  std::atomic<double> sequencer_cpu_s_{0};
};

}  // namespace roseau::daemon
