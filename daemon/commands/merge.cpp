#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "daemon/commands.h"
#include "daemon/commands/failure.h"
#include "daemon/commands/interrupt.h"
#include "daemon/commands/part.h"
#include "daemon/progress.h"
#include "recorder/tools/merge/merge_sessions.h"

namespace roseau::daemon {

namespace {

using Json = nlohmann::ordered_json;

void print_json(const MergeArguments& arguments, const recorder::MergeReport& report) {
  Json json = {{"path", arguments.output.string()},
               {"duration_s", report.duration_s},
               {"messages", report.messages},
               {"duplicates", report.duplicates},
               {"bytes", report.bytes},
               {"stopped", report.stopped},
               {"damage", report.damage}};
  json["sources"] = Json::array();
  for (const auto& input : report.inputs) {
    json["sources"].push_back({{"path", input.path.string()},
                               {"host", input.host},
                               {"session", input.group + 1},
                               {"moved_by", input.moved_by},
                               {"messages", input.messages},
                               {"duplicates", input.duplicates}});
  }
  json["renamed"] = report.renamed;
  fmt::print("{}\n", json.dump(2));
}

void print_text(const MergeArguments& arguments, const recorder::MergeReport& report) {
  fmt::print("{}: {:.1f} s, {} messages, {:.1f} MB\n", arguments.output.string(), report.duration_s, report.messages,
             static_cast<double>(report.bytes) * 1e-6);
  for (const auto& input : report.inputs) {
    fmt::print("  {}: session {} on host {}, {} messages", input.path.string(), input.group + 1, input.host, input.messages);
    if (input.duplicates > 0) fmt::print(", {} of them there already", input.duplicates);
    fmt::print("{}\n", input.moved_by.empty() ? "" : ", moved by " + input.moved_by);
  }
  for (const auto& [from, to] : report.renamed) fmt::print("  {} is now {}\n", from, to);
  if (report.stopped) fmt::print("  stopped early: the file is whole as far as it goes\n");
}

}  // namespace

int merge_command(const MergeArguments& arguments) {
  const Interrupt interrupt;
  Progress progress("merge");
  const auto report =
      recorder::merge_sessions(arguments.files, arguments.output, {.prefixes = arguments.prefixes}, [&](double share) {
        progress.update(share);
        return !interrupt.is_wanted();
      });
  if (!report) return failed(report.error());
  warn_of_damage(report->damage);
  arguments.json ? print_json(arguments, *report) : print_text(arguments, *report);
  return kExitOk;
}

}  // namespace roseau::daemon
