#include "recorder/tools/inspect/stream_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "schema/conversion.h"

namespace roseau::recorder {

namespace {
constexpr std::uint32_t kMostJump = std::uint32_t{1} << 31U;  // more is a step backwards
constexpr std::uint64_t kMostPayloadProblems = 5;             // of one stream, in words
}  // namespace

void StreamCheck::see(const mcap::Channel& channel, const mcap::Schema* schema) {
  if (streams_.contains(channel.id)) return;
  Stream stream;
  stream.report.topic = channel.topic;
  if (channel.topic.empty()) problems_.add(fmt::format("channel {} has no topic", channel.id));
  if (auto info = mcap::stream_info_from(channel, schema); info) {
    stream.kind = sample_kind_from_string(info->kind);
    // What order inputs stand in is roseau's own promise.
    stream.is_raw = info->role == StreamRole::raw && channel.metadata.contains("roseau.role");
    table_.add(std::move(*info));
  }
  choose_check(stream, channel, schema);
  streams_.emplace(channel.id, std::move(stream));
}

void StreamCheck::choose_check(Stream& stream, const mcap::Channel& channel, const mcap::Schema* schema) {
  stream.is_json = channel.message_encoding == "json";
  if (stream.is_json || stream.kind) stream.report.unchecked = "";
  if (channel.message_encoding == "protobuf" && schema != nullptr && schema->encoding == "protobuf") {
    auto checker = schema::PayloadChecker::make(schema->data, schema->name);
    if (checker) {
      stream.checker = std::move(*checker);
    } else {
      problems_.add(fmt::format("{}: {}", channel.topic, checker.error().message));
    }
  }
  if (!stream.is_json && !stream.kind && !stream.checker) {
    stream.report.unchecked = fmt::format("encoding '{}'{}", channel.message_encoding, schema == nullptr ? ", no schema" : "");
  }
}

void StreamCheck::see(const mcap::Message& message) {
  const bool first = messages_ == 0;
  start_time_ns_ = first ? message.log_time_ns : std::min(start_time_ns_, message.log_time_ns);
  end_time_ns_ = std::max(end_time_ns_, message.log_time_ns);
  ++messages_;
  const auto entry = streams_.find(message.channel_id);
  if (entry == streams_.end()) {
    return problems_.add(fmt::format("message {} is of channel {}, which is not described", messages_, message.channel_id));
  }
  Stream& stream = entry->second;
  if (stream.report.messages > 0) check_order(stream, message);
  ++stream.report.messages;
  stream.last_sequence = message.sequence;
  stream.last_log_time_ns = message.log_time_ns;
  check_payload(stream, message);
}

void StreamCheck::check_order(Stream& stream, const mcap::Message& message) {
  // The order of inputs is what replay rests on. Streams stand in chunks of their own, so each is checked by itself.
  if (stream.is_raw && message.log_time_ns <= stream.last_log_time_ns) ++stream.out_of_order;
  const std::uint32_t step = message.sequence - stream.last_sequence;
  if (step == 0 && message.log_time_ns == stream.last_log_time_ns) ++stream.report.repeated;
  if (step == 1) ++stream.steps_of_one;
  if (step <= 1 || step >= kMostJump) return;
  ++stream.report.jumps;
  stream.report.missing += step - 1;
}

void StreamCheck::check_payload(Stream& stream, const mcap::Message& message) {
  if (!stream.report.unchecked.empty()) return;
  ++stream.report.payloads_checked;
  const auto parsed = parse(stream, message);
  if (parsed) return;
  if (++stream.bad_payloads > kMostPayloadProblems) return;
  problems_.add(fmt::format("{}, sequence {}: {}", stream.report.topic, message.sequence, parsed.error().message));
}

Result<void> StreamCheck::parse(const Stream& stream, const mcap::Message& message) const {
  if (stream.checker) {
    if (auto checked = stream.checker->check(message.data); !checked) return checked;
  }
  if (stream.kind == SampleKind::frame) {
    const auto view = schema::parse_frame(message.data, {});
    if (!view) return view.error();
  } else if (stream.kind) {
    const auto sample = schema::parse(*stream.kind, message.data, {}, table_);
    if (!sample) return sample.error();
  } else if (stream.is_json) {
    const auto* text = reinterpret_cast<const char*>(message.data.data());
    if (!nlohmann::json::accept(text, text + message.data.size())) return Error{ErrorCode::corrupt, "is not JSON"};
  }
  return {};
}

void StreamCheck::see(const mcap::TopicCounters& counters) {
  for (auto& [id, stream] : streams_) {
    const auto counted = counters.find(stream.report.topic);
    if (counted == counters.end()) continue;
    stream.report.dropped = counted->second.dropped;
    stream.report.gaps = counted->second.gaps;
    if (counted->second.recorded == stream.report.messages) continue;
    problems_.add(fmt::format("{}: the recorder counted {} messages, the file holds {}", stream.report.topic,
                              counted->second.recorded, stream.report.messages));
  }
}

std::uint64_t StreamCheck::messages_of(std::uint16_t channel_id) const {
  const auto found = streams_.find(channel_id);
  return found == streams_.end() ? 0 : found->second.report.messages;
}

std::map<std::uint16_t, std::uint64_t> StreamCheck::counts() const {
  std::map<std::uint16_t, std::uint64_t> counts;
  for (const auto& [id, stream] : streams_) {
    if (stream.report.messages > 0) counts[id] = stream.report.messages;
  }
  return counts;
}

std::vector<StreamVerification> StreamCheck::finish() {
  std::vector<StreamVerification> reports;
  for (auto& [id, stream] : streams_) {
    if (stream.out_of_order > 0) {
      problems_.add(fmt::format("{}: {} inputs stand out of order (log time does not increase)", stream.report.topic,
                                stream.out_of_order));
    }
    if (stream.bad_payloads > kMostPayloadProblems) {
      problems_.add(fmt::format("{}: {} more messages that do not parse", stream.report.topic,
                                stream.bad_payloads - kMostPayloadProblems));
    }
    // Numbers that do not count messages say nothing about holes.
    if (2 * stream.steps_of_one + 2 <= stream.report.messages) stream.report.jumps = stream.report.missing = 0;
    reports.push_back(std::move(stream.report));
  }
  std::ranges::sort(reports, {}, &StreamVerification::topic);
  return reports;
}

}  // namespace roseau::recorder
