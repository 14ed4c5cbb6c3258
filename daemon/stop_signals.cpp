#include "daemon/stop_signals.h"

#include <pthread.h>

namespace roseau::daemon {

StopSignals::StopSignals() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

void StopSignals::take_trigger() {
  sigaddset(&signals_, SIGUSR1);
  pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
}

bool StopSignals::wait(std::chrono::nanoseconds timeout) const { return wait_for_any(timeout) == Caught::stop; }

StopSignals::Caught StopSignals::wait_for_any(std::chrono::nanoseconds timeout) const {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(timeout);
  const timespec wait{.tv_sec = seconds.count(), .tv_nsec = (timeout - seconds).count()};
  const int signal = sigtimedwait(&signals_, nullptr, &wait);
  if (signal <= 0) return Caught::nothing;
  return signal == SIGUSR1 ? Caught::trigger : Caught::stop;
}

}  // namespace roseau::daemon
