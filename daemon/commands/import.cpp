#include <fmt/format.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/toml/table.h"
#include "daemon/commands.h"
#include "daemon/commands/failure.h"
#include "daemon/progress.h"
#include "daemon/text_file.h"
#include "daemon/version.h"
#include "recorder/recorder.h"
#include "recorder/tools/import/import_session.h"

namespace roseau::daemon {

namespace {

using recorder::ImportPlan;

Result<void> plan_videos(const ImportArguments& arguments, ImportPlan& plan) {
  for (std::size_t i = 0; i < arguments.videos.size(); ++i) {
    auto video = recorder::parse_video_argument(arguments.videos[i], i);
    if (!video) return video.error();
    plan.videos.push_back(std::move(*video));
  }
  return {};
}

Result<void> plan_sonic(const ImportArguments& arguments, ImportPlan& plan) {
  if (!arguments.sonic) return {};
  ImportPlan::Sonic sonic;
  sonic.path = *arguments.sonic;
  sonic.north_offset_deg = arguments.north_offset_deg;
  sonic.start_offset = from_seconds(arguments.start_offset_s);
  sonic.file.columns = arguments.columns.value_or("");
  sonic.file.rate_hz = arguments.sonic_rate_hz;
  const auto format = recorder::table_format_from_string(arguments.sonic_format.empty() ? "auto" : arguments.sonic_format);
  if (!format) return format.error().with_context("--format");
  sonic.file.format = *format;
  if (arguments.temperature_unit) {
    const auto unit = recorder::temperature_unit_from_string(*arguments.temperature_unit);
    if (!unit) return unit.error().with_context("--temperature-unit");
    sonic.file.temperature_unit = *unit;
  }
  plan.sonics.push_back(std::move(sonic));
  return {};
}

Result<void> plan_displacements(const ImportArguments& arguments, ImportPlan& plan) {
  const auto unit = recorder::length_unit_from_string(arguments.displacement_unit);
  if (!unit) return unit.error().with_context("--unit");
  for (const auto& text : arguments.displacements) {
    ImportPlan::DisplacementSeries series;
    const auto equals = text.find('=');
    series.path = equals == std::string::npos ? text : text.substr(equals + 1);
    series.name = equals == std::string::npos ? recorder::series_name(series.path) : text.substr(0, equals);
    series.file.rate_hz = arguments.displacement_rate_hz;
    series.file.unit = *unit;
    series.start_offset = from_seconds(arguments.start_offset_s);
    plan.displacements.push_back(std::move(series));
  }
  return {};
}

Result<ImportPlan> make_plan(const ImportArguments& arguments) {
  ImportPlan plan;
  auto made = plan_videos(arguments, plan);
  if (made) made = plan_sonic(arguments, plan);
  if (made) made = plan_displacements(arguments, plan);
  if (!made) return made.error();
  if (plan.videos.empty() && plan.sonics.empty() && plan.displacements.empty()) {
    return Error{ErrorCode::invalid_argument, "nothing to import: give --video, --sonic or --displacement"};
  }
  return plan;
}

/// The site sheet as it is, if it is TOML.
Result<std::string> read_site(const std::optional<std::filesystem::path>& path) {
  if (!path) return std::string();
  auto text = read_text_file(*path);
  if (!text) return text.error().with_context("site sheet");
  if (auto parsed = TomlTable::parse(*text, path->string()); !parsed) return parsed.error();
  return text;
}

void print_report(const ImportArguments& arguments, const recorder::ImportReport& report, std::uint64_t bytes) {
  if (!arguments.json) {
    fmt::print("{}: {:.1f} s, {:.1f} MB\n", arguments.output.string(), report.duration_s, static_cast<double>(bytes) * 1e-6);
    for (const auto& stream : report.streams) {
      fmt::print("  {} from {}: {} samples, {:.3f}/s", stream.topic, stream.path, stream.samples, stream.rate_hz);
      fmt::print("{}\n", stream.invalid_samples == 0 ? "" : fmt::format(", {} of them not valid", stream.invalid_samples));
      for (const auto& remark : stream.remarks) fmt::print("    {}\n", remark);
    }
    return;
  }
  nlohmann::ordered_json json = {{"path", arguments.output.string()}, {"bytes", bytes}, {"duration_s", report.duration_s}};
  for (const auto& stream : report.streams) {
    json["streams"][stream.topic] = {
        {"path", stream.path},       {"samples", stream.samples}, {"invalid", stream.invalid_samples},
        {"rate_hz", stream.rate_hz}, {"begin_s", stream.begin_s}, {"end_s", stream.end_s},
        {"remarks", stream.remarks}};
  }
  fmt::print("{}\n", json.dump(2));
}

/// Set by SIGINT and SIGTERM: an import then ends early, with a valid file.
volatile std::sig_atomic_t stop_wanted = 0;

Result<recorder::ImportReport> import_into(recorder::Recorder& recorder, recorder::SessionImport& import) {
  std::signal(SIGINT, [](int) { stop_wanted = 1; });
  std::signal(SIGTERM, [](int) { stop_wanted = 1; });
  std::stop_source stop;
  Progress progress("import");
  return import.run(recorder, stop.get_token(), [&](double share) {
    progress.update(share);
    if (stop_wanted != 0) stop.request_stop();
  });
}

}  // namespace

int import_command(const ImportArguments& arguments) {
  const auto plan = make_plan(arguments);
  if (!plan) return failed(plan.error());
  auto site = read_site(arguments.site);
  if (!site) return failed(site.error());
  StreamTable streams;
  auto import = recorder::SessionImport::prepare(*plan, streams);
  if (!import) return failed(import.error());
  recorder::Recorder recorder(streams, {.wait_when_full = true});
  recorder::SessionDescription description;
  description.program_version = kVersion;
  description.site_text = std::move(*site);
  description.utc_minus_host_time = import->utc_minus_host_time();
  description.other["name"] = arguments.output.stem().string();
  if (auto opened = recorder.open(arguments.output, description); !opened) return failed(opened.error());
  const auto report = import_into(recorder, *import);
  const auto closed = recorder.close();
  if (!report) return failed(report.error());
  if (!closed) return failed(closed.error());
  print_report(arguments, *report, recorder.state().bytes);
  return kExitOk;
}

}  // namespace roseau::daemon
