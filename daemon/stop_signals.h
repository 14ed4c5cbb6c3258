// StopSignals: Ctrl-C and SIGTERM as something to wait for; SIGUSR1 where it means something.
#pragma once

#include <chrono>
#include <csignal>
#include <cstdint>

namespace roseau::daemon {

/// From its making on, SIGINT and SIGTERM come to whoever waits here and to nobody else: threads made afterwards inherit the
/// blocked mask. A reader that hangs up is an error of a write then, not a signal.
class StopSignals {
 public:
  StopSignals();
  enum class Caught : std::uint8_t { nothing, stop, trigger };
  /// From now on SIGUSR1 is waited for too.
  void take_trigger();
  Caught wait_for_any(std::chrono::nanoseconds timeout) const;
  /// Waits at most that long; true: stop.
  bool wait(std::chrono::nanoseconds timeout) const;

 private:
  sigset_t signals_{};
};

}  // namespace roseau::daemon
