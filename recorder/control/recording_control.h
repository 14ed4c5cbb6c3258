// RecordingControl: stands between where samples come from and the recorder, and decides what is recorded: policy.h says when,
// past.h keeps what a trigger gets of the time before it. Every sample of a session passes here, with its log time.
//
//   any thread: take() -> idle:      the past
//                      -> recording: the recorder, or, while the past is still being written, a line behind it
//   own thread: makes files, writes the line out, closes files
//
// What a recording needs to be of use alone, and came long before it, stands at its front, restated as of then: how the cameras
// look at the world, and which targets the operator chose. No other sample is recorded twice, and none is lost on the way.
// Order is kept: the past, then what came while it was written, then what comes.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "core/result.h"
#include "core/sample.h"
#include "core/time.h"
#include "recorder/control/past.h"
#include "recorder/control/policy.h"
#include "recorder/recorder.h"

namespace roseau::recorder {

struct ControlOptions {
  PolicyOptions policy;
  PastOptions past;  // its length follows from the policy
  /// Samples that come while the past is written, and for which the past's memory has no room, wait in their cameras' buffers:
  /// at most so many bytes, the same that the recorder's own queue may hold back. More is dropped and counted.
  std::uint64_t waiting_bytes = std::uint64_t{128} << 20U;
};

/// What the control needs done. The first two are called without any of the control's locks held.
struct ControlCallbacks {
  /// Opens the recorder's file for a recording that was begun by `cause`. In the control's thread.
  std::function<Result<void>(const std::string& cause)> open;
  /// A recording has ended; its file is closed. In the control's thread.
  std::function<void(const Result<void>& closed)> closed;
  /// A sample of this stream was dropped because the past was still being written. In whichever thread it came; quick.
  std::function<void(StreamId stream)> lost;
};

struct ControlStatus {
  RecordingPhase phase = RecordingPhase::idle;
  std::string cause;      // empty when idle
  Duration ends_in{0};    // of log time, once an end is set; else 0
  Duration past_span{0};  // what a trigger now would get
  std::uint64_t past_bytes = 0;
  std::uint64_t past_cut_off = 0;  // samples young enough to be kept and without room
  std::uint64_t lost = 0;          // dropped while the past was written
  std::string refusal;             // why nothing may be recorded now; empty: it may
  std::string failure;             // why the last recording could not be begun
};

/// Thread-safe.
class RecordingControl {
 public:
  RecordingControl(Recorder& recorder, ControlOptions options, ControlCallbacks callbacks);
  ~RecordingControl();  // finishes
  RecordingControl(const RecordingControl&) = delete;
  RecordingControl& operator=(const RecordingControl&) = delete;

  /// Every sample, in the order it is to be recorded. False: it was dropped, and counted, by the recorder or here.
  bool take(const Sample& sample, HostTime log_time);
  /// Log time has come to `now` without a sample.
  void tick(HostTime now);

  /// See RecordingPolicy. Error `busy` while recording is refused, with the reason.
  Result<void> start(HostTime at, const std::string& cause);
  Result<void> trigger(HostTime at, const std::string& name);
  Result<void> begin_trigger(HostTime at, const std::string& name);
  void end_trigger(HostTime at, const std::string& name);
  void stop(HostTime at);

  /// The recording ends with the sample taken last, whatever its log time was. What comes may have any log time.
  void end_here();

  /// From now on nothing is begun; empty: it may again. A running recording is not touched.
  void refuse(const std::string& reason);

  /// Returns when everything decided so far has been done: files opened, lines written, files closed. The Error of the last
  /// file that could not be made.
  Result<void> settle();
  /// Ends the recording at once, with everything that was taken, and the thread. The Error of the last close or open.
  /// Idempotent.
  Result<void> finish();

  ControlStatus status() const;

 private:
  struct OpenFile {
    std::string cause;
    std::uint64_t number = 0;  // of the recording
  };
  struct CloseFile {};
  struct Waiting {
    KeptSample kept;
    bool is_leased = false;  // its pixels are its camera's
  };
  using Step = std::variant<OpenFile, Waiting, CloseFile>;

  Result<void> may_begin() const;
  void began(bool is_new, HostTime at);
  void remember(const Sample& sample, HostTime log_time);
  void restate(const std::vector<KeptSample>& past, HostTime at);
  void wait_in_line(KeptSample kept);
  void move_on(HostTime now);
  bool line_up(const Sample& sample, HostTime log_time);
  void lose(StreamId stream);
  void add(Step step);
  void work();
  void carry_out(Step& step);

  Recorder& recorder_;
  const ControlOptions options_;
  const ControlCallbacks callbacks_;

  mutable std::mutex mutex_;
  std::condition_variable work_ready_;
  std::condition_variable settled_;
  RecordingPolicy policy_;
  Past past_;
  HostTime now_ = HostTime::min();
  std::uint64_t recordings_ = 0;     // begun so far
  bool is_file_due_ = false;         // a file's opening stands in the line, or was carried out, and its closing does not
  std::vector<KeptSample> context_;  // calibrations and targets in force
  std::deque<Step> line_;
  bool is_working_ = false;
  bool is_direct_ = false;  // a file is open and nothing waits: samples go straight to the recorder
  bool is_ending_ = false;
  std::uint64_t waiting_bytes_ = 0;  // of the line, without the pixels in our own memory
  std::uint64_t lost_ = 0;
  std::string refusal_;
  std::string failure_;

  // The thread's own.
  bool is_open_ = false;
  Result<void> opened_;  // read by others only while nothing is being done
  Result<void> closed_;

  std::thread thread_;
};

}  // namespace roseau::recorder
