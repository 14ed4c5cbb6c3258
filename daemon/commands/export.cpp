#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "daemon/commands.h"
#include "daemon/commands/failure.h"
#include "daemon/commands/interrupt.h"
#include "daemon/commands/part.h"
#include "daemon/progress.h"
#include "recorder/tools/export/export_session.h"

namespace roseau::daemon {

namespace {

using recorder::ExportReport;

Result<ExportReport> export_as_asked(const ExportArguments& arguments, const recorder::ToolProgress& progress) {
  const auto selection = selection_of(arguments.part);
  if (arguments.csv) return recorder::export_csv(arguments.file, selection, *arguments.csv, progress);
  if (arguments.netcdf) return recorder::export_netcdf(arguments.file, selection, *arguments.netcdf, progress);
  if (arguments.frames) return recorder::export_frames(arguments.file, selection, *arguments.frames, progress);
  if (arguments.video) return recorder::export_video(arguments.file, selection, *arguments.video, progress);
  return recorder::export_toa5(arguments.file, selection, arguments.toa5.value(), progress);
}

void print_json(const ExportReport& report) {
  nlohmann::ordered_json json;
  json["streams"] = nlohmann::ordered_json::object();
  for (const auto& stream : report.streams) {
    json["streams"][stream.topic] = {{"path", stream.path.string()}, {"rows", stream.rows}, {"remark", stream.remark}};
  }
  json["left_out"] = report.left_out;
  json["stopped"] = report.stopped;
  json["damage"] = report.damage;
  fmt::print("{}\n", json.dump(2));
}

void print_text(const ExportReport& report) {
  for (const auto& stream : report.streams) {
    fmt::print("{:<46} {:>9}  {}\n", stream.topic, stream.rows, stream.path.string());
    if (!stream.remark.empty()) fmt::print("  {}\n", stream.remark);
  }
  for (const auto& sentence : report.left_out) fmt::print("left out: {}\n", sentence);
  if (report.stopped) fmt::print("stopped early: what is there is whole as far as it goes\n");
}

}  // namespace

int export_command(const ExportArguments& arguments) {
  const Interrupt interrupt;
  Progress progress("export");
  const auto report = export_as_asked(arguments, [&](double share) {
    progress.update(share);
    return !interrupt.is_wanted();
  });
  if (!report) return failed(report.error());
  warn_of_damage(report->damage);
  arguments.json ? print_json(*report) : print_text(*report);
  return kExitOk;
}

}  // namespace roseau::daemon
