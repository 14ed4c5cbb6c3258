// What a verification found, for people and for machines.

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "recorder/tools/inspect/verification.h"

namespace roseau::recorder {

std::string to_text(const Verification& found) {
  std::string text = fmt::format("{}, {} messages in {} chunks, {} attachments, {} CRCs checked, {} bytes\n",
                                 found.problem_count == 0 ? "whole" : fmt::format("{} problems", found.problem_count),
                                 found.messages, found.chunks, found.attachments, found.crcs_checked, found.bytes);
  for (const auto& problem : found.problems) text += "  " + problem + "\n";
  if (found.problem_count > found.problems.size()) {
    text += fmt::format("  and {} more\n", found.problem_count - found.problems.size());
  }
  for (const auto& remark : found.remarks) text += "  note: " + remark + "\n";
  for (const auto& stream : found.streams) {
    if (!stream.unchecked.empty() && stream.messages > 0) {
      text += fmt::format("  note: {}: payloads not checked ({})\n", stream.topic, stream.unchecked);
    }
    if (stream.missing > 0 || stream.dropped > 0 || stream.gaps > 0) {
      text += fmt::format("  note: {}: {} numbers missing in {} places (device gaps {}, dropped {})\n", stream.topic,
                          stream.missing, stream.jumps, stream.gaps, stream.dropped);
    }
    if (stream.repeated > 0) text += fmt::format("  note: {}: {} messages stand there twice\n", stream.topic, stream.repeated);
  }
  return text;
}

std::string to_json(const Verification& found) {
  nlohmann::ordered_json json = {{"whole", found.problem_count == 0},
                                 {"complete", found.is_complete},
                                 {"bytes", found.bytes},
                                 {"messages", found.messages},
                                 {"chunks", found.chunks},
                                 {"attachments", found.attachments},
                                 {"crcs_checked", found.crcs_checked},
                                 {"problem_count", found.problem_count},
                                 {"problems", found.problems},
                                 {"remarks", found.remarks}};
  json["streams"] = nlohmann::ordered_json::object();
  for (const auto& stream : found.streams) {
    json["streams"][stream.topic] = {{"messages", stream.messages}, {"payloads_checked", stream.payloads_checked},
                                     {"jumps", stream.jumps},       {"missing", stream.missing},
                                     {"repeated", stream.repeated}, {"dropped", stream.dropped},
                                     {"gaps", stream.gaps}};
    if (!stream.unchecked.empty()) json["streams"][stream.topic]["unchecked"] = stream.unchecked;
  }
  return json.dump(2);
}

}  // namespace roseau::recorder
