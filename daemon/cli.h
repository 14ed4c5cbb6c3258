#pragma once

namespace roseau::daemon {

/// Reads the command line and runs the subcommand it names. Returns the process's exit status: 0 ok, 1 failed, 2 wrong use.
int run_command_line(int argc, char** argv);

}  // namespace roseau::daemon
