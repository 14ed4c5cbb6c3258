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
    Result<recorder::Verification> found = Error{ErrorCode::io, ""};
    {
      Progress progress("verify");
      found = recorder::verify_session(file, {.progress = [&progress](double share) {
                                         progress.update(share);
                                         return true;
                                       }});
    }
    if (!found) {
      status = failed(found.error());
      continue;
    }
    if (found->problem_count > 0) status = kExitFailed;
    if (arguments.json) {
      Json one = {{"path", file.string()}};
      one.update(Json::parse(to_json(*found)));
      all.push_back(std::move(one));
    } else {
      fmt::print("{}: {}", file.string(), to_text(*found));
    }
  }
  if (arguments.json) fmt::print("{}\n", (all.size() == 1 ? all.front() : all).dump(2));
  return status;
}

}  // namespace roseau::daemon
