// StopSignals: Ctrl-C and SIGTERM as something to wait for.
#pragma once

#include <chrono>
#include <csignal>

namespace roseau::daemon {

/// From its making on, SIGINT and SIGTERM come to whoever waits here and to nobody else: threads made afterwards inherit the
/// blocked mask. A reader that hangs up is an error of a write then, not a signal.
class StopSignals {
 public:
  StopSignals();
  /// Waits at most that long; true: stop.
  bool wait(std::chrono::nanoseconds timeout) const;

 private:
  sigset_t signals_{};
};

}  // namespace roseau::daemon
