// RecordingPolicy: when is recorded. Pure: log times in, decisions out; no clock, no thread, no file.
//
//   idle -> recording      by the operator, at start, or by a trigger; with the past before it
//   recording -> idle      by the operator's stop
//   recording -> post-trigger -> idle      when the last trigger has ended and nobody holds the recording; triggered again in
//                                          the meantime, it goes on
//
// A recording is an interval of log time, both ends included. Samples do not come strictly by log time (results of the analysis
// come a little after the inputs they were made from), so that an interval that has ended stays open for `settling`.
#pragma once

#include <optional>
#include <set>
#include <string>

#include "core/sample.h"
#include "core/time.h"

namespace roseau::recorder {

struct PolicyOptions {
  Duration pre_trigger{0};                           // of the past that a recording begins with
  Duration post_trigger = std::chrono::seconds(10);  // after the last trigger has ended
  Duration settling = std::chrono::seconds(1);       // results come at most this much later than inputs of the same log time
};

class RecordingPolicy {
 public:
  explicit RecordingPolicy(PolicyOptions options) : options_(options) {}

  /// Records until stop(), whatever triggers do. True: this began a recording.
  bool start(HostTime at, const std::string& cause);
  /// The recording's last log time is `at`; whatever begins after this begins another one. Triggers that are still on do not
  /// begin another one. False: there is none.
  bool stop(HostTime at);

  /// A trigger's condition came true; records until it has ended and the post-trigger time is over. True: this began a
  /// recording.
  bool begin_trigger(HostTime at, const std::string& name);
  void end_trigger(HostTime at, const std::string& name);
  /// Something happened at one moment. True: this began a recording.
  bool trigger(HostTime at, const std::string& name);

  /// Whether there is a recording that samples may belong to: it may have ended already and still be settling.
  bool is_open() const { return is_open_; }
  /// Whether a sample of this log time belongs to it.
  bool wants(HostTime log_time) const;
  /// Log time has come to `now`. True, once: the recording is over, nothing that belongs to it can come any more.
  bool is_over(HostTime now);
  /// Gives the recording up at once: its file could not be made.
  void abandon();

  RecordingPhase phase(HostTime now) const;
  const std::string& cause() const { return cause_; }
  /// The last log time of the recording, where it is known.
  std::optional<HostTime> ends_at() const { return last_; }

 private:
  bool begin(HostTime at, const std::string& cause);

  const PolicyOptions options_;
  bool is_open_ = false;
  bool is_held_ = false;          // by the operator
  bool is_stopped_ = false;       // by stop(): it will not go on
  std::set<std::string> active_;  // triggers whose condition holds
  HostTime first_;                // log times of the recording, both included
  std::optional<HostTime> last_;
  std::string cause_;
};

}  // namespace roseau::recorder
