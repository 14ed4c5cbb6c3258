#include <cstdio>
#include <exception>

#include "daemon/cli.h"
#include "daemon/commands.h"

int main(int argc, char** argv) {
  try {
    return roseau::daemon::run_command_line(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "roseau: unexpected error: %s (a bug in roseau: please report it)\n", error.what());
    return roseau::daemon::kExitFailed;
  }
}
