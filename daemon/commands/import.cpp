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

/// The i-th of `count` files' entry in a list that holds one for each, or one for all, or none. Error: another number.
template <class Value>
Result<std::optional<Value>> entry_of(const std::vector<Value>& list, std::size_t i, std::size_t count, const char* option) {
  if (list.empty()) return std::optional<Value>();
  if (list.size() == 1) return std::optional(list.front());
  if (list.size() == count) return std::optional(list[i]);
  return Error{
      ErrorCode::invalid_argument,
      fmt::format("{} is given {} times for {} files: give it once for all, or once per file", option, list.size(), count)};
}

/// --format belongs to the kind of file that has a format of this name.
struct Formats {
  std::vector<recorder::SonicFormat> sonics;
  std::vector<recorder::TrackerFormat> trackers;
};

Result<Formats> sort_formats(const ImportArguments& arguments) {
  Formats formats;
  for (const auto& name : arguments.formats) {
    const auto sonic = recorder::sonic_format_from_string(name);
    const auto tracker = recorder::tracker_format_from_string(name);
    if (!sonic && !tracker) {
      const auto& error = arguments.sonics.empty() && !arguments.trackers.empty() ? tracker.error() : sonic.error();
      return error.with_context("--format");
    }
    if (sonic && !arguments.sonics.empty()) formats.sonics.push_back(*sonic);
    if (tracker && !arguments.trackers.empty()) formats.trackers.push_back(*tracker);
    if ((!sonic && arguments.trackers.empty()) || (!tracker && arguments.sonics.empty())) {
      return Error{ErrorCode::invalid_argument,
                   fmt::format("--format {} is of {}, and none is given", name, sonic ? "--sonic" : "--tracker")};
    }
  }
  return formats;
}

Result<void> plan_sonics(const ImportArguments& arguments, const Formats& formats, ImportPlan& plan) {
  for (std::size_t i = 0; i < arguments.sonics.size(); ++i) {
    const auto file = recorder::parse_named_file(arguments.sonics[i]);
    const auto format = entry_of(formats.sonics, i, arguments.sonics.size(), "--format");
    if (!format) return format.error();
    const auto north = entry_of(arguments.north_offsets_deg, i, arguments.sonics.size(), "--north-offset");
    if (!north) return north.error();
    ImportPlan::Sonic sonic;
    if (file.name) sonic.name = *file.name;
    sonic.path = file.path;
    sonic.north_offset_deg = north->value_or(0);
    sonic.start_offset = from_seconds(arguments.start_offset_s);
    sonic.file.columns = arguments.columns.value_or("");
    sonic.file.rate_hz = arguments.sonic_rate_hz;
    sonic.file.format = format->value_or(recorder::SonicFormat::automatic);
    if (arguments.temperature_unit) {
      const auto unit = recorder::temperature_unit_from_string(*arguments.temperature_unit);
      if (!unit) return unit.error().with_context("--temperature-unit");
      sonic.file.temperature_unit = *unit;
    }
    plan.sonics.push_back(std::move(sonic));
  }
  return {};
}

Result<void> plan_trackers(const ImportArguments& arguments, const Formats& formats, ImportPlan& plan) {
  for (std::size_t i = 0; i < arguments.trackers.size(); ++i) {
    const auto file = recorder::parse_named_file(arguments.trackers[i]);
    const auto format = entry_of(formats.trackers, i, arguments.trackers.size(), "--format");
    if (!format) return format.error();
    ImportPlan::Tracker tracker;
    if (file.name) tracker.name = *file.name;
    tracker.path = file.path;
    tracker.start_offset = from_seconds(arguments.start_offset_s);
    tracker.file.format = format->value_or(recorder::TrackerFormat::automatic);
    tracker.file.rate_hz = arguments.tracker_rate_hz;
    if (arguments.tracker_unit) {
      const auto unit = recorder::tracker_unit_from_string(*arguments.tracker_unit);
      if (!unit) return unit.error().with_context("--tracker-unit");
      tracker.file.unit = *unit;
    }
    plan.trackers.push_back(std::move(tracker));
  }
  return {};
}

Result<void> plan_displacements(const ImportArguments& arguments, ImportPlan& plan) {
  const auto unit = recorder::length_unit_from_string(arguments.displacement_unit);
  if (!unit) return unit.error().with_context("--unit");
  for (const auto& text : arguments.displacements) {
    ImportPlan::DisplacementSeries series;
    const auto file = recorder::parse_named_file(text);
    series.path = file.path;
    series.name = file.name ? *file.name : recorder::series_name(file.path);
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
  const auto formats = sort_formats(arguments);
  if (!formats) return formats.error();
  if (made) made = plan_sonics(arguments, *formats, plan);
  if (made) made = plan_trackers(arguments, *formats, plan);
  if (made) made = plan_displacements(arguments, plan);
  if (!made) return made.error();
  if (plan.videos.empty() && plan.sonics.empty() && plan.trackers.empty() && plan.displacements.empty()) {
    return Error{ErrorCode::invalid_argument, "nothing to import: give --video, --sonic, --tracker or --displacement"};
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
      if (stream.invalid_samples > 0) fmt::print(", {} of them not valid", stream.invalid_samples);
      if (stream.duplicate_samples > 0) fmt::print(", {} of them repeated", stream.duplicate_samples);
      fmt::print("\n");
      for (const auto& remark : stream.remarks) fmt::print("    {}\n", remark);
    }
    return;
  }
  nlohmann::ordered_json json = {{"path", arguments.output.string()}, {"bytes", bytes}, {"duration_s", report.duration_s}};
  for (const auto& stream : report.streams) {
    json["streams"][stream.topic] = {{"path", stream.path},
                                     {"samples", stream.samples},
                                     {"invalid", stream.invalid_samples},
                                     {"duplicates", stream.duplicate_samples},
                                     {"rate_hz", stream.rate_hz},
                                     {"begin_s", stream.begin_s},
                                     {"end_s", stream.end_s},
                                     {"remarks", stream.remarks}};
  }
  fmt::print("{}\n", json.dump(2));
}

constexpr std::uint64_t kQueueBytes = std::uint64_t{32} << 20U;

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

Result<recorder::SessionImport> look_at(const ImportPlan& plan, StreamTable& streams) {
  Progress progress("look");
  return recorder::SessionImport::prepare(plan, streams, [&](double share) { progress.update(share); });
}

}  // namespace

int import_command(const ImportArguments& arguments) {
  const auto plan = make_plan(arguments);
  if (!plan) return failed(plan.error());
  auto site = read_site(arguments.site);
  if (!site) return failed(site.error());
  StreamTable streams;
  auto import = look_at(*plan, streams);
  if (!import) return failed(import.error());
  // The source is still there after a crash, so chunks may be long: of slow streams, quarters of a second would hold a few
  // samples each, and a month would have millions.
  recorder::Recorder recorder(streams,
                              {.queue_bytes = kQueueBytes, .wait_when_full = true, .chunk_time = std::chrono::seconds(10)});
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
