// Ctrl-C for commands that write a file: asked now and then, so that they end with a whole file.
#pragma once

#include <csignal>

namespace roseau::daemon {

/// From its making on SIGINT and SIGTERM only set a flag. One per process.
class Interrupt {
 public:
  Interrupt() {
    std::signal(SIGINT, [](int) { wanted_ = 1; });
    std::signal(SIGTERM, [](int) { wanted_ = 1; });
  }
  bool is_wanted() const { return wanted_ != 0; }

 private:
  inline static volatile std::sig_atomic_t wanted_ = 0;
};

}  // namespace roseau::daemon
