// info and verify.

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdlib>
#include <string_view>

#include <nlohmann/json.hpp>

#include "daemon/commands.h"
#include "daemon/commands/failure.h"
#include "daemon/progress.h"
#include "recorder/tools/inspect/session_report.h"
#include "recorder/tools/inspect/verification.h"

namespace roseau::daemon {

namespace {

using Json = nlohmann::ordered_json;

std::size_t terminal_width() {
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  constexpr std::size_t kUsual = 100;
  return kUsual;
}

/// What the environment says of the terminal's characters, as the C library would find it.
recorder::TimelineStyle terminal_style() {
  for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"}) {
    const char* value = std::getenv(name);
    if (value == nullptr || *value == '\0') continue;
    const std::string_view locale = value;
    const bool is_utf8 = locale.find("UTF-8") != std::string_view::npos || locale.find("utf8") != std::string_view::npos;
    return is_utf8 ? recorder::TimelineStyle::blocks : recorder::TimelineStyle::ascii;
  }
  return recorder::TimelineStyle::ascii;
}

}  // namespace

int info_command(const FilesArguments& arguments) {
  int status = kExitOk;
  Json all = Json::array();
  for (const auto& file : arguments.files) {
    const std::size_t width = terminal_width();
    const auto report = recorder::inspect_session(file, recorder::slices_in(width));
    if (!report) {
      status = failed(report.error());
    } else if (arguments.json) {
      all.push_back(Json::parse(to_json(*report)));
    } else {
      fmt::print("{}\n{}\n", to_text(*report), to_text(report->timeline, terminal_style()));
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
