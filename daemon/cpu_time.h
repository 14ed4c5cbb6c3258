// CPU time, for the report of where the time went. Never part of a result.
#pragma once

#include <ctime>

namespace roseau::daemon {

/// `clock`: CLOCK_THREAD_CPUTIME_ID (the calling thread) or CLOCK_PROCESS_CPUTIME_ID (the whole process).
inline double cpu_seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

}  // namespace roseau::daemon
