// Supervisor: one thread per source. Opens it, reads it, and when it is lost closes it, waits and opens it again, while all
// other devices run on.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "core/sample.h"
#include "core/source.h"
#include "core/stream.h"
#include "sync/intake.h"

namespace roseau::daemon {

class Supervisor {
 public:
  struct Options {
    std::chrono::milliseconds first_backoff{500};  // doubled after every failure
    std::chrono::milliseconds longest_backoff{10'000};
    /// A running live device that delivers nothing for this long is Degraded ("silent").
    std::chrono::milliseconds silence{3'000};
  };

  Supervisor(Options options, StreamTable& streams, sync::Intake& intake);
  ~Supervisor();

  /// Before start(). `ring_capacity`: samples between the device's thread and the sequencer.
  void add(std::unique_ptr<SampleSource> source, std::size_t ring_capacity);
  void start();
  /// Asks every thread to stop and joins it. Sources are closed. Idempotent.
  void stop();

  /// Thread-safe.
  std::vector<Health::Device> devices() const;
  /// The message of the first source that failed for good, or empty. Thread-safe.
  std::string first_failure() const;
  bool all_finished() const;

 private:
  class Runner;
  Options options_;
  StreamTable& streams_;
  sync::Intake& intake_;
  std::vector<std::unique_ptr<Runner>> runners_;
};

}  // namespace roseau::daemon
