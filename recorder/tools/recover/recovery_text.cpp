// The report of a recovery for people and for machines.

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "recorder/tools/recover/recovery.h"

namespace roseau::recorder {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostStretchesInText = 50;

std::string seconds_text(std::uint64_t time_ns) {
  constexpr std::uint64_t kSecond = 1'000'000'000;
  return fmt::format("{}.{:09}", time_ns / kSecond, time_ns % kSecond);
}

std::string time_text(const LostStretch& stretch) {
  if (stretch.from_ns && stretch.to_ns) {
    return fmt::format(", log time {} to {} s", seconds_text(*stretch.from_ns), seconds_text(*stretch.to_ns));
  }
  if (stretch.from_ns) return fmt::format(", log time from {} s", seconds_text(*stretch.from_ns));
  if (stretch.to_ns) return fmt::format(", log time until {} s", seconds_text(*stretch.to_ns));
  return "";
}

std::string stretch_text(const LostStretch& stretch) {
  std::string text = fmt::format("  lost: bytes {} to {} ({}){}\n        {}\n", stretch.offset, stretch.offset + stretch.bytes,
                                 stretch.bytes, time_text(stretch), stretch.reason);
  if (stretch.saved_messages > 0)
    text += fmt::format("        {} messages saved out of it, unchecked\n", stretch.saved_messages);
  for (const auto& [topic, count] : stretch.messages) text += fmt::format("        {}: {} messages\n", topic, count);
  for (const auto& [topic, count] : stretch.sequence_jump) {
    text += fmt::format("        {}: its numbers jump by {}\n", topic, count);
  }
  return text;
}

Json stretch_json(const LostStretch& stretch) {
  Json json = {{"offset", stretch.offset}, {"bytes", stretch.bytes}, {"reason", stretch.reason}};
  json["from_ns"] = stretch.from_ns ? Json(*stretch.from_ns) : Json(nullptr);
  json["to_ns"] = stretch.to_ns ? Json(*stretch.to_ns) : Json(nullptr);
  json["messages"] = stretch.messages;
  json["sequence_jump"] = stretch.sequence_jump;
  json["saved_messages"] = stretch.saved_messages;
  return json;
}

Json topic_json(const TopicRecovery& topic) {
  Json json = {{"messages", topic.messages},
               {"lost", topic.lost},
               {"missing_in_sequence", topic.missing_in_sequence},
               {"first_ns", topic.first_ns},
               {"last_ns", topic.last_ns}};
  if (topic.counters) {
    const StreamCounters& counters = *topic.counters;
    json["counters"] = {{"received", counters.received}, {"recorded", counters.recorded}, {"dropped", counters.dropped},
                        {"gaps", counters.gaps},         {"bad", counters.bad},           {"late", counters.late}};
  }
  return json;
}

}  // namespace

std::string to_text(const Recovery& recovery) {
  std::string text =
      fmt::format("{}: {} messages in {} chunks, {} attachments, {} of {} bytes lost\n", recovery.output.string(),
                  recovery.messages, recovery.chunks, recovery.attachments, recovery.lost_bytes, recovery.input_bytes);
  if (recovery.was_whole) return text + fmt::format("  {} was whole: nothing was to be mended\n", recovery.input.string());
  for (const auto& remark : recovery.remarks) text += "  " + remark + "\n";
  for (std::size_t i = 0; i < std::min(recovery.lost.size(), kMostStretchesInText); ++i) text += stretch_text(recovery.lost[i]);
  if (recovery.lost.size() > kMostStretchesInText) {
    text += fmt::format("  and {} more stretches (--json lists all)\n", recovery.lost.size() - kMostStretchesInText);
  }
  if (recovery.unchecked_messages > 0) {
    text += fmt::format(
        "  {} messages come from a chunk that is torn: all their bytes are there, but its CRC could not be checked\n",
        recovery.unchecked_messages);
  }
  text += fmt::format("\n  {:<46} {:>10} {:>10} {:>12} {:>10}\n", "topic", "kept", "lost", "number gaps", "dropped");
  for (const auto& topic : recovery.topics) {
    text += fmt::format("  {:<46} {:>10} {:>10} {:>12} {:>10}\n", topic.topic, topic.messages, topic.lost,
                        topic.missing_in_sequence, topic.counters ? fmt::format("{}", topic.counters->dropped) : "?");
  }
  text +=
      "  lost: known to be missing; number gaps: holes in the sequence numbers, the device's own included;\n"
      "  dropped: by the recorder, as it counted last\n";
  if (recovery.torn_bytes) text += fmt::format("  the torn end was kept in {}\n", recovery.torn_bytes->string());
  return text;
}

std::string to_json(const Recovery& recovery) {
  Json json = {{"input", recovery.input.string()},
               {"output", recovery.output.string()},
               {"was_whole", recovery.was_whole},
               {"in_place", recovery.in_place},
               {"input_bytes", recovery.input_bytes},
               {"output_bytes", recovery.output_bytes},
               {"lost_bytes", recovery.lost_bytes},
               {"messages", recovery.messages},
               {"unchecked_messages", recovery.unchecked_messages},
               {"chunks", recovery.chunks},
               {"attachments", recovery.attachments},
               {"metadata", recovery.metadata},
               {"checkpoints", recovery.checkpoints},
               {"remarks", recovery.remarks}};
  json["last_message_ns"] = recovery.last_message_ns ? Json(*recovery.last_message_ns) : Json(nullptr);
  json["lost"] = Json::array();
  for (const auto& stretch : recovery.lost) json["lost"].push_back(stretch_json(stretch));
  json["topics"] = Json::object();
  for (const auto& topic : recovery.topics) json["topics"][topic.topic] = topic_json(topic);
  if (recovery.torn_bytes) json["torn_bytes"] = recovery.torn_bytes->string();
  return json.dump(2);
}

}  // namespace roseau::recorder
