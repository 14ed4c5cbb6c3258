// The one place of the daemon where the host's monotonic clock is read.
#pragma once

#include <chrono>

#include "core/time.h"

namespace roseau::daemon {

/// CLOCK_MONOTONIC: libstdc++'s steady_clock on Linux.
inline HostTime host_now() {
  return HostTime{std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch())};
}

}  // namespace roseau::daemon
