// Recorder: samples of a running session into one MCAP file.
//
//   any thread: record() -> queue bounded in bytes -> writer thread: messages -> chunks -> one writev each
//
// record() never waits for the disk. When the disk is too slow the queue fills: further samples are dropped, counted per stream
// and recorded as Drop samples, and the state becomes degraded. When a write fails (disk full, disk gone) the first error stays
// in the state, nothing more is written, and what was written before remains a readable session.
//
// What is on disk: everything older than a second survives a power cut, everything older than a quarter of a second a crash of
// this program. A cut file reads up to its last whole chunk, and its last checkpoint says what it lacks.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/result.h"
#include "core/sample.h"
#include "core/source.h"
#include "core/stream.h"
#include "core/time.h"
#include "recorder/format/io.h"
#include "recorder/format/topics.h"

namespace roseau::recorder {

/// What the file's head says about the session.
struct SessionDescription {
  std::string program_version;
  std::string config_text;  // the configuration in use, as written by the operator
  std::string site_text;    // the site sheet; empty: none
  std::optional<Duration> utc_minus_host_time;
  mcap::StringMap other;  // further entries of the metadata record "roseau": site name, operator...
};

struct RecorderOptions {
  /// Queued and not yet written, pixels included. Frames wait in their camera's buffers: this must be well below what all
  /// frame pools hold together, or the cameras run out of buffers first.
  std::uint64_t queue_bytes = std::uint64_t{256} << 20U;
  /// What happens when the queue is full: drop and count (live), or let record() wait (import, simulation, replay).
  bool wait_when_full = false;

  /// A chunk is one slice of time: written when it is this large or this long. Wall time counts too.
  std::uint64_t chunk_bytes = std::uint64_t{4} << 20U;
  Duration chunk_time = std::chrono::milliseconds(250);
  /// How often everything is forced to the disk, with a checkpoint of the counters.
  Duration sync_interval = std::chrono::seconds(1);

  /// The same samples give the same file, byte for byte, whatever the machine was doing: chunks are written by their size and
  /// log time alone, and no counters before the end. For simulations; a live recording wants the wall clock's help.
  bool reproducible = false;

  /// Counters kept by others (gaps, bad, late: the sequencer's) to be written with ours, by topic. Called by the writer thread.
  std::function<mcap::TopicCounters()> upstream_counters;
};

struct RecorderState {
  bool recording = false;  // a file is open
  /// starting: nothing recorded yet; running; finished: the file is closed and nothing was lost; degraded: something was lost,
  /// `message` says what and what to do, open or closed; failed: the file could not even be given a proper end.
  DeviceState state = DeviceState::starting;
  std::string message;
  std::string path;         // of the present or the last file
  std::uint64_t bytes = 0;  // written to it
  double seconds = 0;       // of log time in it
  std::uint64_t disk_free_bytes = 0;
  mcap::TopicCounters streams;  // received, recorded, dropped; since open()
};

/// open and close by one thread; record, receive and state by any.
class Recorder : public SampleSink {
 public:
  /// `streams` names the samples' streams and must outlive the recorder.
  explicit Recorder(StreamTable& streams, RecorderOptions options = {});
  ~Recorder() override;  // closes

  /// Makes the file (an existing one is an error), writes its head and starts the writer thread. Errors: the file cannot be
  /// made or written, or another one is open.
  Result<void> open(const std::filesystem::path& path, const SessionDescription& description);
  /// The same into anything writable; `name` is for messages and state().
  Result<void> open(std::unique_ptr<mcap::Writable> out, const std::string& name, const SessionDescription& description);

  /// Takes the sample; frames are shared, not copied. False: it was dropped (and counted). While no file is open, samples are
  /// ignored: true. `log_time` is the order in which a replay feeds the samples: the sequencer's numbering.
  bool record(const Sample& sample, HostTime log_time);

  /// For sources without a sequencer (import, simulation), one thread at a time: the log time is the arrival time made strictly
  /// increasing.
  bool receive(Sample sample) override;

  /// Writes everything queued, the final counters and the summary. An Error when something was lost: the first thing that went
  /// wrong. Nothing to do, no error, when no file is open.
  Result<void> close();

  RecorderState state() const;

 private:
  struct Shared;
  class FileThread;
  Error already_open() const;
  StreamTable& streams_;
  RecorderOptions options_;
  std::unique_ptr<Shared> shared_;
  std::unique_ptr<FileThread> file_;
  HostTime last_received_{Duration::min()};
};

/// Civil time minus host monotonic time, now: for SessionDescription::utc_minus_host_time of a live session.
Duration current_utc_minus_host_time();

}  // namespace roseau::recorder
