#pragma once

#include <cstdio>

#include "core/result.h"
#include "daemon/commands.h"

namespace roseau::daemon {

/// Says what went wrong on standard error; the exit status for it.
inline int failed(const Error& error) {
  std::fputs(("roseau: " + error.message + "\n").c_str(), stderr);
  return kExitFailed;
}

}  // namespace roseau::daemon
