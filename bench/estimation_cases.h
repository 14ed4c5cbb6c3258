// The estimation folder's cases; registered together in estimation_identify.cpp.
#pragma once

#include <ctime>
#include <nlohmann/json.hpp>

#include "core/result.h"

namespace roseau::bench {

/// Of this thread: what a figure costs, whatever else the machine does.
inline double thread_cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

Result<nlohmann::ordered_json> run_identify();
Result<nlohmann::ordered_json> run_online();

}  // namespace roseau::bench
