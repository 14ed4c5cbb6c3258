// The report for people and for machines.

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "recorder/tools/inspect/session_report.h"

namespace roseau::recorder {

namespace {

using Json = nlohmann::ordered_json;

std::string size_text(std::uint64_t bytes) {
  const char* const units[] = {"B", "kB", "MB", "GB", "TB"};
  auto size = static_cast<double>(bytes);
  std::size_t unit = 0;
  while (size >= 1000 && unit + 1 < std::size(units)) {
    size /= 1000;
    ++unit;
  }
  return unit == 0 ? fmt::format("{} B", bytes) : fmt::format("{:.3g} {}", size, units[unit]);
}

/// UTC, ISO 8601; nothing where the session does not know it.
std::optional<std::string> civil_time(const SessionReport& report, HostTime time) {
  if (!report.session.utc_minus_host_time) return std::nullopt;
  const std::int64_t civil_ns = to_ns(time) + report.session.utc_minus_host_time->count();
  const auto seconds = std::chrono::floor<std::chrono::seconds>(std::chrono::nanoseconds(civil_ns));
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}Z", fmt::gmtime(seconds.count()));
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string wind_text(const WindReport& wind) {
  const auto& s = wind.statistics;
  return fmt::format(
      "{} ({} samples{}, north offset {:g} deg, axes {})\n"
      "  unit-vector mean direction        {:8.3f} deg (from)\n"
      "  speed of the mean vector          {:8.3f} m/s\n"
      "  scalar mean speed, 3-D            {:8.3f} m/s\n"
      "  scalar mean speed, horizontal     {:8.3f} m/s\n",
      wind.topic, s.samples(), s.left_out() == 0 ? "" : fmt::format(", {} left out", s.left_out()), wind.north_offset_deg,
      to_string(wind.axes), s.unit_vector_mean_direction_deg(wind.north_offset_deg, wind.axes), s.vector_mean_speed_mps(),
      s.scalar_mean_speed_3d_mps(), s.scalar_mean_speed_horizontal_mps());
}

Json stream_json(const StreamReport& stream, HostTime begin) {
  Json json = {{"kind", stream.info.kind},
               {"schema", stream.schema},
               {"device", stream.info.device},
               {"messages", stream.messages},
               {"rate_hz", stream.rate_hz},
               {"first_s", to_seconds(stream.first - begin)},
               {"last_s", to_seconds(stream.last - begin)}};
  if (stream.counters) {
    const auto& counters = *stream.counters;
    json["counters"] = {{"received", counters.received}, {"recorded", counters.recorded}, {"dropped", counters.dropped},
                        {"gaps", counters.gaps},         {"bad", counters.bad},           {"late", counters.late}};
  }
  if (!stream.unreadable.empty()) json["unreadable"] = stream.unreadable;
  if (stream.counters && stream.counters->dropped > 0) {
    const auto& c = *stream.counters;
    json["dropped_by_stage"] = {
        {"intake", c.dropped_intake}, {"queue", c.dropped_queue}, {"encoder", c.dropped_encoder}, {"write", c.dropped_write}};
  }
  json["metadata"] = stream.info.metadata;
  return json;
}

}  // namespace

namespace {

/// Where samples were lost, for streams that lost any.
std::string drops_text(const SessionReport& report) {
  std::string text;
  for (const auto& stream : report.streams) {
    const auto c = stream.counters.value_or(StreamCounters{});
    const std::pair<const char*, std::uint64_t> stages[] = {{"between device and sequencer", c.dropped_intake},
                                                            {"for a slow disk", c.dropped_queue},
                                                            {"by the image encoder", c.dropped_encoder},
                                                            {"by failed writes", c.dropped_write}};
    for (const auto& [where, count] : stages) {
      if (count > 0) text += fmt::format("dropped: {} of {} {}\n", count, stream.info.topic, where);
    }
  }
  return text.empty() ? text : "\n" + text;
}

Json timeline_json(const Timeline& timeline) {
  Json json = {{"slice_s", timeline.slice_s()}, {"lines", Json::object()}, {"marks", Json::array()}};
  for (const auto& line : timeline.lines) json["lines"][line.topic] = line_text(line, TimelineStyle::ascii);
  for (const auto& mark : timeline.marks) {
    json["marks"].push_back({{"time_s", mark.time_s}, {"trigger", mark.is_trigger}, {"text", mark.text}});
  }
  return json;
}

}  // namespace

std::string to_text(const SessionReport& report) {
  std::string text =
      fmt::format("{}: {}, {:.1f} s", report.path.string(), size_text(report.bytes), to_seconds(report.end - report.begin));
  if (const auto begin = civil_time(report, report.begin)) text += fmt::format(", from {}", *begin);
  if (!report.session.program_version.empty()) text += fmt::format(", by roseau {}", report.session.program_version);
  text += "\n";
  if (!report.session.session_id.empty()) {
    text += fmt::format("part {} of session {}\n", report.session.part, report.session.session_id);
  }
  for (const auto& damage : report.damage) text += fmt::format("damaged: {}\n", damage);
  text += fmt::format("\n{:<46} {:<18} {:>9} {:>9} {:>6} {:>7}\n", "stream", "kind", "messages", "rate/s", "gaps", "dropped");
  for (const auto& stream : report.streams) {
    const auto counters = stream.counters.value_or(StreamCounters{});
    text += fmt::format("{:<46} {:<18} {:>9} {:>9.3f} {:>6} {:>7}\n", stream.info.topic,
                        stream.unreadable.empty() ? stream.info.kind : stream.schema, stream.messages, stream.rate_hz,
                        counters.gaps, counters.dropped);
    if (!stream.unreadable.empty()) text += fmt::format("  cannot be read: {}\n", stream.unreadable);
  }
  text += drops_text(report);
  for (const auto& wind : report.winds) text += "\n" + wind_text(wind);
  for (const auto& [name, bytes] : report.attachments) text += fmt::format("\nattached: {} ({})", name, size_text(bytes));
  return text + "\n";
}

std::string to_json(const SessionReport& report) {
  Json json = {{"path", report.path.string()},
               {"bytes", report.bytes},
               {"complete", report.is_complete},
               {"damage", report.damage},
               {"program_version", report.session.program_version},
               {"schema_version", report.session.schema_version},
               {"duration_s", to_seconds(report.end - report.begin)}};
  if (const auto begin = civil_time(report, report.begin)) json["begin_utc"] = *begin;
  if (!report.session.session_id.empty()) {
    json["session_id"] = report.session.session_id;
    json["part"] = report.session.part;
  }
  json["timeline"] = timeline_json(report.timeline);
  json["session"] = report.session.other;
  json["streams"] = Json::object();
  for (const auto& stream : report.streams) json["streams"][stream.info.topic] = stream_json(stream, report.begin);
  json["wind"] = Json::object();
  for (const auto& wind : report.winds) {
    const auto& s = wind.statistics;
    json["wind"][wind.topic] = {
        {"samples", s.samples()},
        {"left_out", s.left_out()},
        {"north_offset_deg", wind.north_offset_deg},
        {"unit_vector_mean_direction_deg", number(s.unit_vector_mean_direction_deg(wind.north_offset_deg, wind.axes))},
        {"vector_mean_speed_mps", number(s.vector_mean_speed_mps())},
        {"scalar_mean_speed_3d_mps", number(s.scalar_mean_speed_3d_mps())},
        {"scalar_mean_speed_horizontal_mps", number(s.scalar_mean_speed_horizontal_mps())}};
  }
  json["attachments"] = Json::object();
  for (const auto& [name, bytes] : report.attachments) json["attachments"][name] = bytes;
  return json.dump(2);
}

}  // namespace roseau::recorder
