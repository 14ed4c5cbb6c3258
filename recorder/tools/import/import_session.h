// Carries an import plan out: files in, samples out, in order of their times. Where a file holds what a device sent, these
// bytes are the raw stream, and what live decoding would make of them follows as the derived one.
//
// However long the files are, at most about 1 MB of each is held at a time (frames apart).
//
//   StreamTable streams;
//   auto import = SessionImport::prepare(plan, streams);       // reads and checks everything; nothing is written yet
//   Recorder recorder(streams, {.wait_when_full = true});      // or any other sink
//   recorder.open(path, {.utc_minus_host_time = import->utc_minus_host_time(), ...});
//   auto report = import->run(recorder, stop_token, progress);
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/source.h"
#include "core/stream.h"
#include "recorder/tools/import/import_plan.h"

namespace roseau::recorder {

struct ImportReport {
  struct Stream {
    std::string topic;
    std::string path;
    std::uint64_t samples = 0;
    std::uint64_t invalid_samples = 0;
    std::uint64_t duplicate_samples = 0;  // the device's last values again, flagged so
    double rate_hz = 0;
    double begin_s = 0;  // since the session's first sample
    double end_s = 0;
    std::vector<std::string> remarks;  // for people: what was taken for what, what was doubtful
  };
  std::vector<Stream> streams;
  double duration_s = 0;
  bool was_stopped = false;
};

class SessionImport {
 public:
  /// Reads every file but the videos once from end to end, opens every video and declares every stream. Error: the first thing
  /// that is wrong, naming the file. `progress`: from 0 to 1, by file.
  static Result<SessionImport> prepare(const ImportPlan& plan, StreamTable& streams,
                                       const std::function<void(double)>& progress = {});

  SessionImport(SessionImport&&) noexcept;
  SessionImport& operator=(SessionImport&&) noexcept;
  ~SessionImport();

  /// Add it to any time of the session: civil time (UTC; time stamps in files are taken as UTC). Nothing when no file and no
  /// plan told.
  std::optional<Duration> utc_minus_host_time() const;

  /// Hands everything to `sink`, once. A sink that does not take a sample is an Error; so is a video that breaks off.
  /// `progress` is called now and then with a value from 0 to 1. A stop request ends early and well.
  Result<ImportReport> run(SampleSink& sink, const std::stop_token& stop = {},
                           const std::function<void(double)>& progress = {});

 private:
  struct State;
  class Counter;
  ImportReport report() const;
  explicit SessionImport(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace roseau::recorder
