#include "recorder/session_writer.h"

#include <algorithm>
#include <utility>

#include "recorder/image_storage.h"
#include "recorder/recorder.h"
#include "schema/conversion.h"

namespace roseau::recorder {

namespace {
// Coded frames in one chunk: small ones must not take all the buffers there are, waiting for it to become large.
constexpr std::size_t kMostCoded = 16;
}  // namespace

SessionWriter::SessionWriter(mcap::Writable& out, const StreamTable& streams, const RecorderOptions& options)
    : out_(out), writer_(out), streams_(streams), options_(options) {}

Result<void> SessionWriter::begin(const SessionDescription& description, const PartHead& head) {
  if (auto begun = writer_.begin({"x-roseau", "roseau " + description.program_version}); !begun) return begun;
  mcap::SessionInfo info{.schema_version = schema::kSchemaVersion,
                         .program_version = description.program_version,
                         .utc_minus_host_time = description.utc_minus_host_time,
                         .other = description.other,
                         .session_id = head.session_id,
                         .part = head.part,
                         .repeated_messages = static_cast<std::uint32_t>(head.repeated.size())};
  if (auto written = writer_.write(to_metadata(info)); !written) return written;
  const std::pair<std::string_view, const std::string&> texts[] = {{mcap::kConfigAttachment, description.config_text},
                                                                   {mcap::kSiteAttachment, description.site_text}};
  for (const auto& [name, text] : texts) {
    if (text.empty()) continue;
    const mcap::Attachment attachment{
        .name = std::string(name), .media_type = std::string(mcap::kTomlMediaType), .data = std::as_bytes(std::span(text))};
    if (auto written = writer_.write(attachment); !written) return written;
  }
  for (const Sample& sample : head.repeated) {
    if (auto added = add(sample, sample.header.arrival_time, 0); !added) return added;
  }
  return flush();  // they are the first messages of the file
}

Result<std::uint16_t> SessionWriter::schema_id_of(const StreamInfo& stored) {
  const auto id = static_cast<std::uint16_t>(schema_ids_.size() + 1);
  const mcap::Schema schema = mcap::make_schema(stored, id);
  if (const auto known = schema_ids_.find(schema.name); known != schema_ids_.end()) return known->second;
  if (auto written = writer_.write(schema); !written) return written.error();
  schema_ids_[schema.name] = id;
  return id;
}

/// Schemas and channels stand outside of chunks, before their first message: a damaged chunk then costs only itself.
Result<std::uint16_t> SessionWriter::channel_id_of(const Sample& sample) {
  const StreamId stream = sample.header.stream;
  if (stream >= channel_ids_.size()) channel_ids_.resize(stream + 1U);
  if (channel_ids_[stream]) return *channel_ids_[stream];
  const StreamInfo stored = stored_stream(sample, streams_.info(stream), options_);
  ROSEAU_CHECK(stored.kind == to_string(sample.kind()));
  const auto schema_id = schema_id_of(stored);
  if (!schema_id) return schema_id.error();
  if (auto written = writer_.write(mcap::make_channel(stored, next_channel_id_, *schema_id)); !written) return written.error();
  channel_ids_[stream] = next_channel_id_;
  return next_channel_id_++;
}

/// Into head_; what is returned follows it.
std::span<const std::byte> SessionWriter::serialize_head(const Sample& sample, bool is_coded) {
  return is_coded ? schema::serialize_coded_head(sample, streams_, head_) : schema::serialize_head(sample, streams_, head_);
}

Result<void> SessionWriter::add(const Sample& sample, HostTime log_time, std::uint64_t budget_bytes) {
  const auto* frame = std::get_if<Frame>(&sample.payload);
  const bool is_coded = storage_of(sample, streams_.info(sample.header.stream), options_) != ImageStorage::raw;
  if (frame != nullptr && !(is_coded ? static_cast<bool>(frame->coded) : static_cast<bool>(frame->pixels))) {
    ++written_.lost_in_encoder[sample.header.stream];
    written_.budget_bytes += budget_bytes;
    return {};
  }
  const auto channel_id = channel_id_of(sample);
  if (!channel_id) {
    ++written_.lost[sample.header.stream];
    written_.budget_bytes += budget_bytes;
    return channel_id.error();
  }
  OpenChunk& open = frame != nullptr ? images_ : small_;
  const auto pixels = serialize_head(sample, is_coded);
  open.chunk.add({.channel_id = *channel_id,
                  .sequence = sample.header.sequence,
                  .log_time_ns = mcap::log_time_from(log_time),
                  .publish_time_ns = mcap::log_time_from(sample.header.sample_time),
                  .data = head_},
                 pixels);
  if (frame != nullptr) open.leases.push_back(is_coded ? frame->coded.lease : frame->pixels);
  ++open.held.samples[sample.header.stream];
  open.held.budget_bytes += budget_bytes;

  const auto slice_ns = static_cast<std::uint64_t>(options_.chunk_time.count());
  const bool full = open.chunk.uncompressed_bytes() >= options_.chunk_bytes || (is_coded && open.leases.size() >= kMostCoded);
  const bool long_enough = open.chunk.end_time_ns() - open.chunk.start_time_ns() >= slice_ns;
  return full || long_enough ? write(open) : Result<void>{};
}

Result<void> SessionWriter::write(OpenChunk& open) {
  if (open.chunk.empty()) return {};
  if (auto written = writer_.write(open.chunk); !written) return written;
  written_.budget_bytes += open.held.budget_bytes;
  appended_.push_back({writer_.bytes_written(), std::move(open.held.samples)});
  clear(open);
  return {};
}

Written SessionWriter::take_written() {
  const std::uint64_t reached = out_.written();
  for (; !appended_.empty() && appended_.front().end <= reached; appended_.pop_front()) {
    for (const auto& [stream, count] : appended_.front().samples) written_.samples[stream] += count;
  }
  return std::exchange(written_, {});
}

std::uint64_t SessionWriter::bytes_with(const Sample& sample) {
  // Beside the messages themselves: their heads and index entries, a checkpoint, and the counters at the end.
  constexpr std::uint64_t kPerMessage = 64;
  constexpr std::uint64_t kPerChunk = 512;
  constexpr std::uint64_t kPerStream = 2048;
  std::uint64_t bytes = writer_.bytes_written() + writer_.end_bytes() + kPerStream * (streams_.size() + 1);
  for (const OpenChunk* open : {&images_, &small_}) {
    bytes += open->chunk.uncompressed_bytes() + kPerChunk + kPerMessage * (open->chunk.message_count() + 1);
  }
  const StreamId stream = sample.header.stream;
  if (stream >= channel_ids_.size() || !channel_ids_[stream]) {  // written twice: before the first message, and in the summary
    const StreamInfo& info = streams_.info(stream);
    for (const auto& [key, value] : info.metadata) bytes += 2 * (8 + key.size() + value.size());
    const mcap::Schema schema = mcap::make_schema(stored_stream(sample, info, options_), 1);
    if (!schema_ids_.contains(schema.name)) bytes += 2 * schema.data.size();
  }
  const auto* frame = std::get_if<Frame>(&sample.payload);
  const auto pixels = serialize_head(sample, frame != nullptr && frame->coded);
  return bytes + head_.size() + pixels.size();
}

void SessionWriter::clear(OpenChunk& open) {
  open.held = {};
  open.leases.clear();
  open.chunk.clear();
  open.older = false;
}

Result<void> SessionWriter::flush() {
  auto written = write(images_);
  return written ? write(small_) : written;
}

Result<void> SessionWriter::flush_older() {
  for (OpenChunk* open : {&images_, &small_}) {
    if (open->older) {
      if (auto written = write(*open); !written) return written;
    }
    open->older = !open->chunk.empty();
  }
  return {};
}

Result<void> SessionWriter::checkpoint(const mcap::Metadata& counters) {
  return writer_.write_private(mcap::kCheckpointOpcode, counters);
}

Result<void> SessionWriter::finish(const mcap::Metadata& counters) {
  if (auto written = writer_.write(counters); !written) return written;
  return writer_.finish();
}

void SessionWriter::abandon() {
  const std::uint64_t reached = out_.written();
  std::erase_if(appended_, [&](const Appended& chunk) {
    if (chunk.end <= reached) return false;
    for (const auto& [stream, count] : chunk.samples) written_.lost[stream] += count;
    return true;
  });
  for (OpenChunk* open : {&images_, &small_}) {
    written_.budget_bytes += open->held.budget_bytes;
    for (const auto& [stream, count] : open->held.samples) written_.lost[stream] += count;
    clear(*open);
  }
}

}  // namespace roseau::recorder
