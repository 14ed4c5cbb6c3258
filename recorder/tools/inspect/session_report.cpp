#include "recorder/tools/inspect/session_report.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "recorder/format/indexed_reader.h"
#include "schema/conversion.h"

namespace roseau::recorder {

namespace {

constexpr std::uint64_t kMostWindBytes = std::uint64_t{256} << 20U;

/// Bytes of the blocks that hold the channel.
std::uint64_t spread(mcap::IndexedReader& reader, std::uint16_t channel) {
  std::uint64_t bytes = 0;
  for (const auto& block : reader.index().blocks) {
    if (!block.channels || std::ranges::binary_search(*block.channels, channel)) bytes += block.length;
  }
  return bytes;
}

/// Time of the last message of a channel: somewhere in the last blocks that may hold it.
Result<std::optional<HostTime>> last_time(mcap::IndexedReader& reader, std::uint16_t channel) {
  // Blocks are ordered by their start; one that starts earlier may end later, so all whose end reaches the latest start of
  // a block with this channel are looked at.
  std::uint64_t from_ns = 0;
  for (const auto& block : reader.index().blocks) {
    const bool may_hold = !block.channels || std::ranges::binary_search(*block.channels, channel);
    if (may_hold) from_ns = std::max(from_ns, block.start_time_ns);
  }
  auto messages = reader.messages({.channels = {{channel}}, .start_time_ns = from_ns});
  std::optional<HostTime> last;
  for (auto message = messages.next();; message = messages.next()) {
    if (!message) return message.error();
    if (!*message) return last;
    last = mcap::host_time_from((*message)->message.publish_time_ns);
  }
}

Result<void> read_span(mcap::IndexedReader& reader, std::uint16_t channel, StreamReport& stream) {
  auto messages = reader.messages({.channels = {{channel}}});
  const auto first = messages.next();
  if (!first) return first.error();
  if (!*first) return {};
  stream.first = mcap::host_time_from((*first)->message.publish_time_ns);
  const auto last = last_time(reader, channel);
  if (!last) return last.error();
  stream.last = last->value_or(stream.first);
  const double span_s = to_seconds(stream.last - stream.first);
  if (stream.messages > 1 && span_s > 0) stream.rate_hz = static_cast<double>(stream.messages - 1) / span_s;
  return {};
}

Result<WindReport> read_wind(mcap::IndexedReader& reader, std::uint16_t channel, const StreamInfo& info) {
  WindReport wind;
  wind.topic = info.topic;
  if (const auto found = info.metadata.find("north_offset_deg"); found != info.metadata.end()) {
    wind.north_offset_deg = std::strtod(found->second.c_str(), nullptr);
  }
  if (const auto found = info.metadata.find("axes"); found != info.metadata.end()) {
    if (const auto axes = wind_axes_from_string(found->second); axes) wind.axes = *axes;
  }
  const StreamTable no_streams;
  auto messages = reader.messages({.channels = {{channel}}});
  for (auto message = messages.next();; message = messages.next()) {
    if (!message) return message.error();
    if (!*message) return wind;
    const auto sample = schema::parse(SampleKind::wind, (*message)->message.data, {}, no_streams);
    if (!sample) return sample.error();
    wind.statistics.add(std::get<WindSample>(sample->payload));
  }
}

/// The final counters, or those of the last checkpoint in a file that was cut off.
Result<mcap::TopicCounters> read_counters(mcap::IndexedReader& reader) {
  auto metadata = reader.find_metadata(mcap::kCountersMetadata);
  if (!metadata) return metadata.error();
  if (*metadata) return mcap::counters_from(**metadata);
  const auto& records = reader.index().private_records;
  for (auto record = records.rbegin(); record != records.rend(); ++record) {
    if (record->opcode != static_cast<std::uint8_t>(mcap::kCheckpointOpcode)) continue;
    const auto checkpoint = reader.read(*record);
    if (!checkpoint) return checkpoint.error();
    return mcap::counters_from(*checkpoint);
  }
  return mcap::TopicCounters{};
}

Result<void> read_streams(mcap::IndexedReader& reader, SessionReport& report) {
  const auto counters = read_counters(reader);
  if (!counters) return counters.error();
  const auto& counts = reader.index().statistics.channel_message_counts;
  for (const auto& [id, channel] : reader.catalog().channels()) {
    const mcap::Schema* schema = reader.catalog().schema_of(channel);
    StreamReport stream;
    stream.schema = schema != nullptr ? schema->name : "";
    stream.info.topic = channel.topic;
    if (const auto found = counts.find(id); found != counts.end()) stream.messages = found->second;
    if (auto info = mcap::stream_info_from(channel, schema); info) {
      stream.info = std::move(*info);
    } else {
      stream.unreadable = info.error().message;
    }
    if (const auto found = counters->find(channel.topic); found != counters->end()) stream.counters = found->second;
    if (auto span = read_span(reader, id, stream); !span) return span;
    if (stream.unreadable.empty() && stream.info.kind == to_string(SampleKind::wind) && spread(reader, id) < kMostWindBytes) {
      auto wind = read_wind(reader, id, stream.info);
      if (!wind) return wind.error().with_context(channel.topic);
      report.winds.push_back(std::move(*wind));
    }
    report.streams.push_back(std::move(stream));
  }
  std::ranges::sort(report.streams, {}, [](const StreamReport& stream) { return stream.info.topic; });
  std::ranges::sort(report.winds, {}, &WindReport::topic);
  return {};
}

}  // namespace

Result<SessionReport> inspect_session(const std::filesystem::path& path, std::size_t slices) {
  auto reader = mcap::IndexedReader::open(path);
  if (!reader) return reader.error();
  const auto& index = (*reader)->index();
  SessionReport report;
  report.path = path;
  std::error_code no_size;
  report.bytes = std::filesystem::file_size(path, no_size);
  report.is_complete = index.complete;
  report.damage = index.damage;
  report.begin = mcap::host_time_from(index.statistics.message_start_time_ns);
  report.end = mcap::host_time_from(index.statistics.message_end_time_ns);
  for (const auto& attachment : index.attachments) report.attachments.emplace_back(attachment.name, attachment.data_size);
  auto metadata = (*reader)->find_metadata(mcap::kSessionMetadata);
  if (!metadata) return metadata.error().with_context(path.string());
  if (*metadata) {
    auto info = mcap::session_info_from(**metadata);
    if (!info) return info.error().with_context(path.string());
    report.session = std::move(*info);
  }
  if (auto streams = read_streams(**reader, report); !streams) return streams.error().with_context(path.string());
  auto timeline = make_timeline(path, **reader, slices);
  if (!timeline) return timeline.error().with_context(path.string());
  report.timeline = std::move(*timeline);
  return report;
}

}  // namespace roseau::recorder
