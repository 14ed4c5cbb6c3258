// info and verify.

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "daemon/commands.h"
#include "daemon/commands/failure.h"
#include "daemon/progress.h"
#include "recorder/tools/inspect/session_report.h"
#include "recorder/tools/inspect/verification.h"

namespace roseau::daemon {

namespace {

using Json = nlohmann::ordered_json;

std::string verdict(const std::filesystem::path& path, const recorder::Verification& found) {
  std::string text = fmt::format("{}: {}, {} messages, {} bytes\n", path.string(),
                                 found.problem_count == 0 ? "whole" : fmt::format("{} problems", found.problem_count),
                                 found.messages, found.bytes);
  for (const auto& problem : found.problems) text += "  " + problem + "\n";
  if (found.problem_count > found.problems.size()) {
    text += fmt::format("  and {} more\n", found.problem_count - found.problems.size());
  }
  return text;
}

}  // namespace

int info_command(const FilesArguments& arguments) {
  int status = kExitOk;
  Json all = Json::array();
  for (const auto& file : arguments.files) {
    const auto report = recorder::inspect_session(file);
    if (!report) {
      status = failed(report.error());
    } else if (arguments.json) {
      all.push_back(Json::parse(to_json(*report)));
    } else {
      fmt::print("{}", to_text(*report));
    }
  }
  if (arguments.json) fmt::print("{}\n", (all.size() == 1 ? all.front() : all).dump(2));
  return status;
}

int verify_command(const FilesArguments& arguments) {
  int status = kExitOk;
  Json all = Json::array();
  for (const auto& file : arguments.files) {
    Progress progress("verify");
    const auto found = recorder::verify_session(file, [&progress](double share) { progress.update(share); });
    if (!found) {
      status = failed(found.error());
      continue;
    }
    if (found->problem_count > 0) status = kExitFailed;
    if (arguments.json) {
      all.push_back({{"path", file.string()},
                     {"whole", found->problem_count == 0},
                     {"bytes", found->bytes},
                     {"messages", found->messages},
                     {"attachments", found->attachments},
                     {"problem_count", found->problem_count},
                     {"problems", found->problems}});
    } else {
      fmt::print("{}", verdict(file, *found));
    }
  }
  if (arguments.json) fmt::print("{}\n", (all.size() == 1 ? all.front() : all).dump(2));
  return status;
}

}  // namespace roseau::daemon
