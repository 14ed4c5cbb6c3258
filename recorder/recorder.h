// Recorder: samples of a running session into one MCAP file.
//
//   any thread: record() -> queue bounded in bytes -> writer thread: messages -> chunks -> one writev each
//
// record() never waits for the disk. When the disk is too slow the queue fills: further samples are dropped, counted per stream
// and recorded as Drop samples, and the state becomes degraded. When a write fails (disk full, disk gone) the first error stays
// in the state, nothing more is written, and what was written before remains a readable session.
//
// A session may be split into parts: files that each read alone. The writer thread goes over to the next file exactly between
// two samples, so that every sample is in exactly one part, in the order in which it was recorded; the old file is finished by
// another thread meanwhile.
//
// What is on disk: everything older than a second survives a power cut, everything older than a quarter of a second a crash of
// this program. A cut file reads up to its last whole chunk, and its last checkpoint says what it lacks.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

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

  /// To go on with a session that was interrupted: its id, and the number of the part that begins now. Empty: a new session,
  /// whose id the recorder makes (RecorderState::session_id).
  std::string session_id;
  std::uint32_t first_part = 1;
};

/// When the next part is begun: before the first sample that would bring the file beyond `bytes` (its end, the summary,
/// included, so that no part with more than one sample is larger), or whose log time is `time` or more after the first sample
/// of the part; whichever comes first. 0: not for this reason.
struct SplitRule {
  std::uint64_t bytes = 0;
  Duration time{0};
};

/// A file that was closed.
struct FinishedPart {
  std::filesystem::path path;
  std::string session_id;
  std::uint32_t part = 1;   // its number
  std::uint64_t bytes = 0;  // its size
  double seconds = 0;       // of log time in it
  bool last = false;        // closed by close(), not by a split
  std::string problem;      // why it was not closed properly (it reads up to its last whole chunk); empty: it is whole
};

/// "a.mcap", 2 -> "a.part002.mcap"; part 1 keeps its name.
std::filesystem::path default_part_path(const std::filesystem::path& first, std::uint32_t part);

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

  /// How frames are stored, by device; those of other devices as their stream says (a session that is replayed), else raw.
  /// Frames that come with a stored form of their own keep it; where png or jpeg is wanted, all others become PNG, on threads
  /// of the recorder's (image_coder.h). JPEG is made by the camera (drivers/camera/jpeg), never here.
  std::map<std::string, ImageStorage> image_storage;

  /// Counters kept by others (gaps, bad, late: the sequencer's) to be written with ours, by topic. Called by the writer thread.
  std::function<mcap::TopicCounters()> upstream_counters;

  /// When a recording is split by itself; Recorder::split_now works in any case.
  SplitRule split;
  /// The file of part `part` (one more than the last) of the recording whose first file is `first`. Called by the writer
  /// thread, which waits: quick. A file that exists already is an error, and treated as one that cannot be made.
  std::function<std::filesystem::path(const std::filesystem::path& first, std::uint32_t part)> part_path = default_part_path;
  /// How the file of a further part is made; for tests. Empty: FileWritable::create.
  std::function<Result<std::unique_ptr<mcap::Writable>>(const std::filesystem::path& path)> create_part;

  /// Called once for every file that was opened, in order, after its last byte is on the disk and its descriptor is closed: it
  /// may be read, copied or deleted now. From the finishing thread; for the last part from the writer thread, before close()
  /// returns. It may take long (copying): only later calls of this wait for it, no sample does, but close() does. It must not
  /// call open() or close() of this recorder; record(), split_now() and state() it may.
  std::function<void(const FinishedPart& part)> part_finished;
};

struct RecorderState {
  bool recording = false;  // a file is open
  /// starting: nothing recorded yet; running; finished: the file is closed and nothing was lost; degraded: something was lost,
  /// `message` says what and what to do, open or closed; failed: the file could not even be given a proper end.
  DeviceState state = DeviceState::starting;
  std::string message;
  std::string path;         // of the present or the last file
  std::uint64_t bytes = 0;  // written to it: they can be read
  double seconds = 0;       // of log time in the session, all parts
  std::uint64_t disk_free_bytes = 0;
  mcap::TopicCounters streams;  // received, recorded, dropped by stage; since open()

  std::string session_id;
  std::uint32_t part = 1;             // number of the present or the last file
  std::uint64_t session_bytes = 0;    // written to all parts since open()
  std::uint32_t parts_finishing = 0;  // left behind by a split, not yet closed
  /// Why the last wish to split was not fulfilled: the next file could not be made, recording goes on in the present one.
  /// Tried again after a sync interval. `state` is degraded and `message` says it too while it lasts, though nothing is lost.
  std::string split_problem;
};

class WriterThread;

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

  /// The same, but waits while the queue is full, whatever the options say. For samples that were kept back before: a burst
  /// that may take as long as it needs. False: a write has failed, or the file is being closed.
  bool record_waiting(const Sample& sample, HostTime log_time);

  /// For sources without a sequencer (import, simulation), one thread at a time: the log time is the arrival time made strictly
  /// increasing.
  bool receive(Sample sample) override;

  /// Writes everything queued, the final counters and the summary. An Error when something was lost: the first thing that went
  /// wrong. Nothing to do, no error, when no file is open.
  Result<void> close();

  /// Begins the next part between the samples recorded before this call and those after it: when the first of these comes
  /// (without one there is no further part), and only if the present part has a sample. Returns at once; whether it could be
  /// done is in the state. Any thread. Error when nothing is being recorded.
  Result<void> split_now();

  RecorderState state() const;

 private:
  struct Shared;
  Error already_open() const;
  StreamTable& streams_;
  RecorderOptions options_;
  std::unique_ptr<Shared> shared_;
  std::unique_ptr<WriterThread> writer_;
  HostTime last_received_{Duration::min()};
};

/// Civil time minus host monotonic time, now: for SessionDescription::utc_minus_host_time of a live session.
Duration current_utc_minus_host_time();

}  // namespace roseau::recorder
