#include "recorder/tools/cut/cut_session.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "daemon/commands.h"
#include "daemon/commands/failure.h"
#include "daemon/commands/interrupt.h"
#include "daemon/commands/part.h"
#include "daemon/progress.h"

namespace roseau::daemon {

namespace {

constexpr const char* kFreshStart =
    "begins in mid-run: a replay starts its analysis anew here, and its first minute is not what was shown live";

void print_json(const CutArguments& arguments, const recorder::CutReport& report) {
  const nlohmann::ordered_json json = {{"path", arguments.output.string()},
                                       {"source", arguments.file.string()},
                                       {"begin_s", report.begin_s},
                                       {"end_s", report.end_s},
                                       {"messages", report.messages},
                                       {"bytes", report.bytes},
                                       {"chunks_copied", report.chunks_copied},
                                       {"chunks_rebuilt", report.chunks_rebuilt},
                                       {"carried", report.carried},
                                       {"begins_in_mid_run", report.begins_in_mid_run},
                                       {"stopped", report.stopped},
                                       {"damage", report.damage}};
  fmt::print("{}\n", json.dump(2));
}

void print_text(const CutArguments& arguments, const recorder::CutReport& report) {
  fmt::print("{}: {:.3f} s to {:.3f} s of {}, {} messages, {:.1f} MB\n", arguments.output.string(), report.begin_s,
             report.end_s, arguments.file.filename().string(), report.messages, static_cast<double>(report.bytes) * 1e-6);
  fmt::print("  {} chunks copied as they are, {} made anew\n", report.chunks_copied, report.chunks_rebuilt);
  if (report.carried > 0) fmt::print("  {} messages from before it, that held at its start\n", report.carried);
  if (report.begins_in_mid_run) fmt::print("  {}\n", kFreshStart);
  if (report.stopped) fmt::print("  stopped early: the file is whole as far as it goes\n");
}

}  // namespace

int cut_command(const CutArguments& arguments) {
  const Interrupt interrupt;
  Progress progress("cut");
  const auto report = recorder::cut_session(arguments.file, arguments.output, selection_of(arguments.part), [&](double share) {
    progress.update(share);
    return !interrupt.is_wanted();
  });
  if (!report) return failed(report.error());
  warn_of_damage(report->damage);
  arguments.json ? print_json(arguments, *report) : print_text(arguments, *report);
  return kExitOk;
}

}  // namespace roseau::daemon
