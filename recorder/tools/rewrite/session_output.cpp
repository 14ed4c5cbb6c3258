#include "recorder/tools/rewrite/session_output.h"

#include <system_error>
#include <utility>

#include "recorder/format/chunk_content.h"
#include "recorder/format/crc32.h"
#include "schema/conversion.h"
#include "schema/recorded_header.h"

namespace roseau::recorder {

namespace {

constexpr std::uint64_t kChunkBytes = std::uint64_t{4} << 20U;
constexpr std::uint64_t kChunkTime_ns = 250'000'000;
constexpr std::uint16_t kBadStatus = kStatusBadChecksum | kStatusMalformed | kStatusDeviceError | kStatusIncomplete;

bool holds_pictures(const mcap::Schema* schema) {
  return schema != nullptr && (schema->name.ends_with("Image") || schema->name.ends_with("CompressedVideo"));
}

}  // namespace

// ---------------------------------------------------------------------------------------------------------------------

void MessageCounter::add_channel(const mcap::Channel& channel, const mcap::Schema* schema) {
  Stream& stream = streams_[channel.id];
  stream.topic = channel.topic;
  if (const auto info = mcap::stream_info_from(channel, schema); info) stream.kind = sample_kind_from_string(info->kind);
}

void MessageCounter::add(const mcap::Message& message) {
  Stream& stream = streams_[message.channel_id];
  ++stream.counters.recorded;
  if (!stream.kind) return;
  if (const auto header = schema::read_header(*stream.kind, message.data, {})) {
    if ((header->status & kBadStatus) != 0) ++stream.counters.bad;
    if ((header->status & kStatusLate) != 0) ++stream.counters.late;
  }
  if (stream.kind != SampleKind::drop && stream.kind != SampleKind::gap) return;
  const auto sample = schema::parse(*stream.kind, message.data, {}, no_streams_);
  if (!sample) return;
  if (const auto* gap = std::get_if<Gap>(&sample->payload)) gaps_[gap->topic] += gap->missing;
  // What tracking or a page did without is in the file all the same.
  const auto* drop = std::get_if<Drop>(&sample->payload);
  if (drop != nullptr && drop->stage != "tracking" && drop->stage != "display") dropped_[drop->topic] += drop->count;
}

mcap::TopicCounters MessageCounter::counters() const {
  mcap::TopicCounters counters;
  for (const auto& [id, stream] : streams_) {
    if (!stream.topic.empty()) counters[stream.topic] = stream.counters;
  }
  for (auto& [topic, counts] : counters) {
    if (const auto dropped = dropped_.find(topic); dropped != dropped_.end()) counts.dropped = dropped->second;
    if (const auto gaps = gaps_.find(topic); gaps != gaps_.end()) counts.gaps = gaps->second;
    counts.received = counts.recorded + counts.dropped;
  }
  return counters;
}

// ---------------------------------------------------------------------------------------------------------------------

Result<std::unique_ptr<SessionOutput>> SessionOutput::create(const std::filesystem::path& path, const mcap::Header& header) {
  auto file = mcap::FileWritable::create(path);
  if (!file) return file.error();
  std::unique_ptr<SessionOutput> output(new SessionOutput(std::move(*file), path));
  if (auto begun = output->writer_.begin(header); !begun) return begun.error();
  return output;
}

SessionOutput::~SessionOutput() {
  if (finished_) return;
  file_.reset();
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

Result<void> SessionOutput::write(const mcap::Channel& channel, const mcap::Schema* schema) {
  is_picture_[channel.id] = holds_pictures(schema);
  counter_.add_channel(channel, schema);
  return writer_.write(channel);
}

Result<void> SessionOutput::add(const mcap::Message& message) {
  counter_.add(message);
  mcap::ChunkBuilder& chunk = is_picture_[message.channel_id] ? pictures_ : small_;
  chunk.add(message);
  const bool is_long = chunk.end_time_ns() - chunk.start_time_ns() >= kChunkTime_ns;
  return chunk.uncompressed_bytes() >= kChunkBytes || is_long ? flush(chunk) : Result<void>{};
}

Result<void> SessionOutput::flush(mcap::ChunkBuilder& chunk) {
  auto written = writer_.write(chunk);
  chunk.clear();
  return written;
}

Result<void> SessionOutput::copy_chunk(const mcap::Chunk& chunk, std::span<const std::byte> records) {
  // What was gathered before comes before it.
  for (mcap::ChunkBuilder* gathered : {&pictures_, &small_}) {
    if (auto written = flush(*gathered); !written) return written;
  }
  return writer_.copy(chunk, mcap::crc32(0, chunk.records), mcap::chunk_content(records));
}

Result<void> SessionOutput::finish() {
  Result<void> done = flush(pictures_);
  if (done) done = flush(small_);
  file_->begin_closing();
  if (done) done = writer_.write(mcap::to_metadata(counter_.counters()));
  if (done) done = writer_.finish();
  if (done) done = file_->close();
  finished_ = done.has_value();
  return done;
}

Result<mcap::SessionInfo> read_session_info(mcap::IndexedReader& reader) {
  auto metadata = reader.find_metadata(mcap::kSessionMetadata);
  if (!metadata) return metadata.error();
  if (!*metadata) return mcap::SessionInfo{};
  return mcap::session_info_from(**metadata);
}

}  // namespace roseau::recorder
