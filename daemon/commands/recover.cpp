// recover.

#include <fmt/format.h>

#include <csignal>

#include "daemon/commands.h"
#include "daemon/commands/failure.h"
#include "daemon/progress.h"
#include "recorder/tools/recover/recovery.h"

namespace roseau::daemon {

namespace {

/// Set by SIGINT and SIGTERM: the unfinished output is then removed.
volatile std::sig_atomic_t stop_wanted = 0;

/// session.mcap -> session.recovered.mcap, beside it.
std::filesystem::path output_for(const std::filesystem::path& input) {
  return input.parent_path() / (input.stem().string() + ".recovered.mcap");
}

}  // namespace

int recover_command(const RecoverArguments& arguments) {
  std::signal(SIGINT, [](int) { stop_wanted = 1; });
  std::signal(SIGTERM, [](int) { stop_wanted = 1; });
  Result<recorder::Recovery> recovery = Error{ErrorCode::io, ""};
  {
    Progress progress("recover");
    const recorder::RecoverOptions options{.progress = [&progress](double share) {
      progress.update(share);
      return stop_wanted == 0;
    }};
    recovery = arguments.in_place
                   ? recorder::recover_in_place(arguments.file, options)
                   : recorder::recover_session(arguments.file, arguments.output.value_or(output_for(arguments.file)), options);
  }
  if (!recovery) return failed(recovery.error());
  fmt::print("{}\n", arguments.json ? to_json(*recovery) : to_text(*recovery));
  return kExitOk;
}

}  // namespace roseau::daemon
