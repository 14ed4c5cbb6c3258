// Recording: all there is about recording in a running session. It puts together what recorder/ and recorder/control/ do, by
// the configuration: when is recorded, into which files, how they are split, what happens when the disk fills or the battery
// empties, the copy on a second disk, and what a crash left.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/sample.h"
#include "core/stream.h"
#include "daemon/config.h"
#include "recorder/control/battery.h"
#include "recorder/control/disk_guard.h"
#include "recorder/control/recording_control.h"
#include "recorder/control/second_copy.h"
#include "recorder/control/session_files.h"
#include "recorder/control/trigger.h"
#include "recorder/recorder.h"

namespace roseau::daemon {

struct RecordingPlan {
  RecordingConfig config;
  std::string name;  // of the session: how files begin
  recorder::SessionDescription description;
  bool is_replay = false;  // everything is recorded, nothing is watched, actions are history
  bool has_pictures = false;
  bool at_start = false;
  std::optional<std::filesystem::path> file;          // record into exactly this one
  std::map<std::string, ImageStorage> image_storage;  // see recorder::RecorderOptions
};

/// What Recording needs of the rest.
struct RecordingCallbacks {
  /// Counters kept by others: see recorder::RecorderOptions.
  std::function<mcap::TopicCounters()> upstream_counters;
  /// A mark that is to become an input of the session: which trigger fired, and why.
  std::function<void(OperatorAction)> mark;
  /// A sample of this stream was dropped before the recorder.
  std::function<void(StreamId)> lost;

  // What tests put in place of the machine.
  std::function<std::optional<std::uint64_t>(const std::filesystem::path&)> free_bytes;  // empty: asks the file system
  std::function<recorder::Power()> power;                                                // empty: asks Linux
  std::function<std::chrono::system_clock::time_point()> civil_now;                      // empty: the system's clock
};

class Recording {
 public:
  Recording(StreamTable& streams, RecordingPlan plan, RecordingCallbacks callbacks);
  ~Recording();
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  /// Before the first sample: looks what a crash left, and begins recording where that is wanted from the start. Error: the
  /// file cannot be made.
  Result<void> begin();

  /// Every input, in the order it is numbered; obeys the operator's actions among them. Sequencer's thread.
  void input(const Sample& sample, HostTime log_time);
  /// Every sample of the analysed stream; those that are derived are recorded, all are looked at by the triggers. One thread.
  void analysed(const Sample& sample, HostTime log_time);
  /// What roseau says about itself. Any thread.
  void about_itself(const Sample& sample, HostTime log_time);

  /// Whether the operator may do this now. Any thread.
  Result<void> allows(const OperatorAction& action) const;

  /// Several times a second, live, by the control loop.
  void look_after(HostTime now);

  /// The recording ends with the sample taken last, and its file is closed: time is about to go back.
  void end_here();

  /// Returns when files are opened and closed as decided so far, and old ones recovered.
  void settle();

  /// Writes what there is, closes the file, and gives the copy a little time. Idempotent.
  Result<void> finish();

  /// Completes what the recorder itself says. Any thread.
  void report(Health& health) const;
  bool is_recording() const { return control_.status().phase != RecordingPhase::idle; }
  const recorder::Recorder& recorder() const { return recorder_; }

 private:
  recorder::RecorderOptions recorder_options();
  recorder::ControlOptions control_options() const;
  recorder::ControlCallbacks control_callbacks();
  const std::filesystem::path& directory() const { return plan_.config.directory; }

  Result<void> open(const std::string& cause);
  Result<void> open_next(const std::string& cause);
  Result<void> open_resumed(const std::string& cause, const recorder::RecordingMarker::Note& note);
  Result<void> open_marked(const std::filesystem::path& path, recorder::RecordingMarker::Note note,
                           recorder::SessionDescription description);
  void part_finished(const recorder::FinishedPart& part);
  void recover(recorder::Interrupted left);
  void recover_file(const std::filesystem::path& file, const std::stop_token& stop);
  void obey(const OperatorAction& action, HostTime log_time);
  void on_trigger(const recorder::TriggerEvent& event);

  void watch_disk(HostTime now);
  void make_room(std::uint64_t missing_bytes, std::uint64_t free_bytes);
  std::uint64_t remove_files(const std::vector<recorder::SessionFile>& files);
  void refuse(HostTime now, const std::string& reason);
  void warn_of_silent_triggers(HostTime now);

  StreamTable& streams_;
  RecordingPlan plan_;
  RecordingCallbacks callbacks_;
  std::unique_ptr<recorder::SecondCopy> copy_;
  recorder::Recorder recorder_;
  recorder::RecordingControl control_;
  recorder::TriggerWatch triggers_;

  // The control's thread and the recorder's.
  std::mutex files_mutex_;
  std::optional<recorder::RecordingMarker> marker_;
  std::optional<recorder::RecordingMarker::Note> resumed_;  // to go on with, once

  // The control loop's.
  std::optional<HostTime> first_look_;
  HostTime next_look_ = HostTime::min();
  HostTime next_listing_ = HostTime::min();
  std::uint64_t recordings_bytes_ = 0;
  recorder::WriteRate rate_;
  recorder::DiskGuard disk_guard_;
  recorder::BatteryGuard battery_guard_;
  bool was_held_ = false;  // stopped by a guard, though somebody wants it recorded
  bool warned_of_triggers_ = false;

  // What the control loop found, for the others.
  mutable std::mutex found_mutex_;
  struct Found {
    double left_s = 0;
    double bytes_per_s = 0;
    std::uint64_t free_bytes = 0;
    std::string refusal;
    std::vector<std::string> warnings;
    recorder::Power power;
    recorder::BatteryVerdict battery;
  } found_;

  std::jthread recovery_;
};

}  // namespace roseau::daemon
