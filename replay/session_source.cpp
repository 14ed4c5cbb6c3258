#include "replay/session_source.h"

#include <algorithm>
#include <thread>

#include "core/log.h"
#include "schema/conversion.h"

namespace roseau::replay {

namespace {

constexpr int kMessagesPerRead = 64;
constexpr std::size_t kPoolBytes = std::size_t{256} << 20U;
constexpr std::size_t kFewestFrames = 32;
constexpr std::size_t kMostFrames = 64;
constexpr std::chrono::milliseconds kPoolWait{1};
constexpr int kPoolWaits = 2000;
// Between the end of one round of a loop and the start of the next.
constexpr Duration kLoopPause = std::chrono::milliseconds(40);

std::string text_of(std::span<const std::byte> bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

}  // namespace

SessionSource::SessionSource(std::string name, std::unique_ptr<mcap::IndexedReader> reader, ReplayOptions options)
    : name_(std::move(name)), reader_(std::move(reader)), options_(std::move(options)) {}

SessionSource::~SessionSource() = default;

Result<std::unique_ptr<SessionSource>> SessionSource::open_file(const std::filesystem::path& path, ReplayOptions options) {
  auto reader = mcap::IndexedReader::open(path);
  if (!reader) return reader.error();
  std::unique_ptr<SessionSource> source(new SessionSource(path.filename().string(), std::move(*reader), std::move(options)));
  if (auto read = source->read_session(); !read) return read.error().with_context(path.string());
  return source;
}

Result<void> SessionSource::read_session() {
  const auto& index = reader_->index();
  if (auto metadata = reader_->find_metadata(mcap::kSessionMetadata); !metadata) {
    return metadata.error();
  } else if (*metadata) {
    auto info = mcap::session_info_from(**metadata);
    if (!info) return info.error();
    info_ = std::move(*info);
  }
  for (const auto& [id, channel] : index.catalog.channels()) {
    const mcap::Schema* schema = index.catalog.schema_of(channel);
    auto stream = mcap::stream_info_from(channel, schema);
    if (!stream) {
      log("replay")->warn("{}: {}", channel.topic, stream.error().message);
      continue;
    }
    if (stream->role != StreamRole::raw) continue;
    const auto kind = sample_kind_from_string(stream->kind);
    ROSEAU_CHECK(kind.has_value());  // stream_info_from gives only kinds that there are
    inputs_.emplace(id, Input{*kind, std::move(*stream)});
  }
  if (inputs_.empty()) {
    return Error{ErrorCode::invalid_argument,
                 "holds no inputs that could be played: record or import a session first (roseau info shows what it holds)"};
  }
  begin_ = mcap::host_time_from(index.statistics.message_start_time_ns);
  end_ = mcap::host_time_from(index.statistics.message_end_time_ns);
  pacer_ = std::make_unique<Pacer>(begin_, end_, options_.speed, options_.now);
  if (auto texts = read_texts(); !texts) return texts;
  return read_skips();
}

Result<void> SessionSource::read_texts() {
  std::vector<std::byte> buffer;
  for (const auto& attachment : reader_->index().attachments) {
    std::string* text = attachment.name == mcap::kConfigAttachment ? &config_text_
                        : attachment.name == mcap::kSiteAttachment ? &site_text_
                                                                   : nullptr;
    if (text == nullptr) continue;
    auto read = reader_->read(attachment, buffer);
    if (!read) return read.error();
    *text = text_of(read->data);
  }
  return {};
}

/// Skips are needed before the frames they are about, which they follow in the file.
Result<void> SessionSource::read_skips() {
  mcap::MessageQuery query;
  query.channels.emplace();
  for (const auto& [id, input] : inputs_) {
    if (input.kind == SampleKind::skip) query.channels->push_back(id);
  }
  if (query.channels->empty()) return {};
  StreamTable streams;
  for (const auto& [id, input] : inputs_) streams.add(input.info);
  auto messages = reader_->messages(std::move(query));
  for (auto message = messages.next(); message && *message; message = messages.next()) {
    const auto sample = schema::parse(SampleKind::skip, (*message)->message.data, {}, streams);
    if (!sample) return sample.error();
    const auto& skip = std::get<Skip>(sample->payload);
    skips_.emplace(streams.info(skip.stream).topic, skip.sequence);
  }
  return {};
}

std::vector<std::string> SessionSource::cameras() const {
  std::set<std::string> devices;
  for (const auto& [id, input] : inputs_) {
    if (input.kind == SampleKind::frame) devices.insert(input.info.device);
  }
  return {devices.begin(), devices.end()};
}

Result<void> SessionSource::open(StreamTable& streams) {
  streams_ = &streams;
  for (auto& [id, input] : inputs_) input.stream = streams.add(input.info);
  restart_messages();
  return {};
}

void SessionSource::restart_messages() {
  mcap::MessageQuery query;
  query.channels.emplace();
  for (const auto& [id, input] : inputs_) query.channels->push_back(id);
  messages_.emplace(reader_->messages(std::move(query)));
  next_.reset();
}

void SessionSource::shift(SampleHeader& header) const {
  header.arrival_time += loop_shift_;
  header.sample_time += loop_shift_;
  if (header.device_time) *header.device_time += loop_shift_;
}

/// Frames wait for a free buffer: replay may always wait. Should the consumers keep more frames than there are buffers (a long
/// window at a high rate), a second pool is better than a standstill.
Result<Sample> SessionSource::parse_waiting(const Input& input, const mcap::Message& message) {
  SampleHeader known;
  known.stream = input.stream;
  known.sequence = message.sequence;
  known.arrival_time = mcap::host_time_from(message.log_time_ns);
  known.sample_time = mcap::host_time_from(message.publish_time_ns);
  if (input.kind != SampleKind::frame) return schema::parse(input.kind, message.data, known, *streams_);

  const auto view = schema::parse_frame(message.data, known);
  if (!view) return view.error();
  const auto make_pool = [this, &view] {
    const std::size_t count =
        std::clamp(kPoolBytes / std::max<std::size_t>(view->pixels.size(), 1), kFewestFrames, kMostFrames);
    frames_ = std::make_unique<FramePool>(count, view->pixels.size());
  };
  if (frames_ == nullptr || frames_->buffer_bytes() < view->pixels.size()) make_pool();
  for (int waits = 0; frames_->free_count() == 0; ++waits) {
    if (waits == kPoolWaits) make_pool();
    std::this_thread::sleep_for(kPoolWait);
  }
  return schema::parse(input.kind, message.data, known, *streams_, frames_.get());
}

Result<ReadStatus> SessionSource::read(SampleSink& sink, std::chrono::milliseconds timeout) {
  for (int count = 0; count < kMessagesPerRead; ++count) {
    if (!next_) {
      auto message = messages_->next();
      if (!message) {
        log("replay")->warn("{}: {}; going on behind it", name_, message.error().message);
        continue;
      }
      if (!*message) {
        if (!options_.loop) {
          pacer_->end();
          return ReadStatus::finished;
        }
        loop_shift_ += end_ - begin_ + kLoopPause;
        pacer_->restart();
        restart_messages();
        return ReadStatus::more;
      }
      next_ = *message;
    }
    const HostTime due = mcap::host_time_from(next_->message.log_time_ns);
    if (const Duration wait = pacer_->until_due(due); wait > Duration{0}) {
      if (count > 0) return ReadStatus::more;
      std::this_thread::sleep_for(std::min<Duration>(wait, timeout));
      if (wait > timeout) return ReadStatus::idle;
    }
    pacer_->reached(due);
    const Input& input = inputs_.at(next_->channel->id);
    auto sample = parse_waiting(input, next_->message);
    next_.reset();
    if (!sample) {
      log("replay")->warn("{} on {}: {}; left out", name_, input.info.topic, sample.error().message);
      continue;
    }
    shift(sample->header);
    sink.receive(std::move(*sample));
  }
  return ReadStatus::more;
}

}  // namespace roseau::replay
