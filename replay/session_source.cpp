#include "replay/session_source.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <thread>

#include "core/log.h"
#include "schema/conversion.h"

namespace roseau::replay {

namespace {

constexpr int kMessagesPerRead = 64;
constexpr std::size_t kPoolBytes = std::size_t{256} << 20U;
constexpr std::size_t kFewestFrames = 32;
// Very large pictures (a broken file may declare some) get fewer.
constexpr std::size_t kMostPoolBytes = std::size_t{1} << 30U;
constexpr std::size_t kFewestLargeFrames = 4;
constexpr std::size_t kMostFrames = 64;
constexpr std::chrono::milliseconds kPoolWait{1};
constexpr int kPoolWaits = 2000;
// How much before a place that is sought small samples start, so that there are values to show; and how far back its pictures
// are looked for: near first, because looking reads them.
constexpr Duration kLeadIn = std::chrono::seconds(2);
constexpr std::array<Duration, 3> kFrameReach = {std::chrono::milliseconds(100), std::chrono::seconds(1),
                                                 std::chrono::seconds(10)};

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
  if (auto skips = read_skips(); !skips) return skips;
  return read_marks();
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

/// All samples of one kind among the inputs, ahead of the replay: there are few of these.
Result<void> SessionSource::read_all(SampleKind kind, const std::function<void(const Sample&, const StreamTable&)>& take) {
  mcap::MessageQuery query;
  query.channels = channels_of([kind](SampleKind one) { return one == kind; });
  if (query.channels->empty()) return {};
  StreamTable streams;
  for (const auto& [id, input] : inputs_) streams.add(input.info);
  auto messages = reader_->messages(std::move(query));
  for (auto message = messages.next(); message && *message; message = messages.next()) {
    SampleHeader known;
    known.sample_time = mcap::host_time_from((*message)->message.publish_time_ns);
    const auto sample = schema::parse(kind, (*message)->message.data, known, streams);
    if (!sample) return sample.error();
    take(*sample, streams);
  }
  return {};
}

/// Skips are needed before the frames they are about, which they follow in the file.
Result<void> SessionSource::read_skips() {
  return read_all(SampleKind::skip, [this](const Sample& sample, const StreamTable& streams) {
    const auto& skip = std::get<Skip>(sample.payload);
    skips_.emplace(streams.info(skip.stream).topic, skip.sequence);
  });
}

Result<void> SessionSource::read_marks() {
  return read_all(SampleKind::operator_action, [this](const Sample& sample, const StreamTable&) {
    const auto& action = std::get<OperatorAction>(sample.payload);
    const bool is_mark = action.kind == OperatorAction::Kind::mark || action.kind == OperatorAction::Kind::note;
    if (is_mark) marks_.push_back({sample.header.sample_time, action.text});
  });
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
  start_at(begin_);
  return {};
}

std::vector<StreamInfo> SessionSource::inputs() const {
  std::vector<StreamInfo> streams;
  for (const auto& [id, input] : inputs_) streams.push_back(input.info);
  return streams;
}

std::vector<std::uint16_t> SessionSource::channels_of(const std::function<bool(SampleKind)>& wanted) const {
  std::vector<std::uint16_t> channels;
  for (const auto& [id, input] : inputs_) {
    if (wanted(input.kind)) channels.push_back(id);
  }
  return channels;
}

void SessionSource::add_stretch(const std::vector<std::uint16_t>& channels, HostTime begin, HostTime end) {
  if (channels.empty() || begin > end) return;
  mcap::MessageQuery query;
  query.channels = channels;
  query.start_time_ns = mcap::log_time_from(begin);
  query.end_time_ns = mcap::log_time_from(end);
  stretches_.push_back(std::move(query));
}

void SessionSource::start_at(HostTime place) {
  next_.reset();
  messages_.reset();
  stretches_.clear();
  starts_.clear();
  flushed_ = false;
  const auto all = channels_of([](SampleKind) { return true; });
  if (place <= begin_) {
    add_stretch(all, begin_, HostTime::max());
    return;
  }
  const auto frames = last_frames_until(place);
  HostTime pictures_begin = place;
  for (const auto& [id, time] : frames) pictures_begin = std::min(pictures_begin, time);
  const HostTime others_begin = std::max(begin_, place - kLeadIn);
  for (const auto& [id, input] : inputs_) {
    const auto frame = frames.find(id);
    starts_[id] = frame != frames.end() ? frame->second : input.kind == SampleKind::frame ? place : others_begin;
    if (input.kind == SampleKind::operator_action) starts_[id] = begin_;
  }
  const Duration instant{1};
  const HostTime first = std::min(others_begin, pictures_begin);
  add_stretch(channels_of([](SampleKind kind) { return kind == SampleKind::operator_action; }), begin_, first - instant);
  // Pictures fill nearly all of the file: those before the ones wanted are not even read.
  add_stretch(channels_of([](SampleKind kind) { return kind != SampleKind::frame; }), first, pictures_begin - instant);
  add_stretch(all, pictures_begin, HostTime::max());
}

/// By channel, when the last frame up to `place` was taken; cameras that were silent for long before it are not in the map.
std::map<std::uint16_t, HostTime> SessionSource::last_frames_until(HostTime place) {
  std::map<std::uint16_t, HostTime> last;
  const auto cameras = channels_of([](SampleKind kind) { return kind == SampleKind::frame; });
  HostTime searched_from = place + Duration{1};
  for (const Duration reach : kFrameReach) {
    mcap::MessageQuery query;
    query.channels.emplace();
    std::ranges::copy_if(cameras, std::back_inserter(*query.channels), [&last](auto id) { return !last.contains(id); });
    if (query.channels->empty() || searched_from <= begin_) break;
    const HostTime from = std::max(begin_, place - reach);
    query.start_time_ns = mcap::log_time_from(from);
    query.end_time_ns = mcap::log_time_from(searched_from - Duration{1});
    auto messages = reader_->messages(std::move(query));
    while (true) {
      const auto message = messages.next();
      if (!message) continue;  // a damaged part: told about when it is played
      if (!*message) break;
      last[(*message)->channel->id] = mcap::host_time_from((*message)->message.log_time_ns);
    }
    searched_from = from;
  }
  return last;
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
  wait_for_buffer(frames_, view->pixel_bytes());
  auto sample = schema::parse(input.kind, message.data, known, *streams_, frames_.get());
  if (!sample || view->storage == ImageStorage::raw) return sample;
  // Recorded again, the picture is to have the form that it has here: coding twice would change it, or be for nothing.
  wait_for_buffer(stored_, view->coded.size());
  CodedImage& coded = std::get<Frame>(sample->payload).coded;
  coded = {.lease = stored_->acquire(), .size = view->coded.size(), .format = view->storage};
  std::ranges::copy(view->coded, coded.lease.writable_bytes().begin());
  return sample;
}

/// Afterwards the pool has a free buffer of at least so many bytes: only this thread takes some.
void SessionSource::wait_for_buffer(std::unique_ptr<FramePool>& pool, std::size_t bytes) {
  const auto make_pool = [&pool, bytes] {
    const std::size_t with_room = bytes + bytes / 4;  // coded pictures differ in size
    const std::size_t fewest = std::clamp(kMostPoolBytes / with_room, kFewestLargeFrames, kFewestFrames);
    const std::size_t count = std::clamp(kPoolBytes / with_room, fewest, kMostFrames);
    pool = std::make_unique<FramePool>(count, with_room);
  };
  if (pool == nullptr || pool->buffer_bytes() < bytes) make_pool();
  for (int waits = 0; pool->free_count() == 0; ++waits) {
    if (waits == kPoolWaits) make_pool();
    std::this_thread::sleep_for(kPoolWait);
  }
}

/// False: the session has no more.
bool SessionSource::read_next() {
  while (!next_) {
    if (!messages_) {
      if (stretches_.empty()) return false;
      messages_.emplace(reader_->messages(std::move(stretches_.front())));
      stretches_.pop_front();
    }
    auto message = messages_->next();
    if (!message) {
      log("replay")->warn("{}: {}; going on behind it", name_, message.error().message);
    } else if (!*message) {
      messages_.reset();
    } else {
      const auto start = starts_.find((*message)->channel->id);
      const bool too_early = start != starts_.end() && mcap::host_time_from((*message)->message.log_time_ns) < start->second;
      if (!too_early) next_ = *message;
    }
  }
  return true;
}

Result<ReadStatus> SessionSource::at_end(SampleSink& sink, std::chrono::milliseconds timeout) {
  const bool playing = pacer_->state().playing;
  if (options_.loop && playing) {
    pacer_->restart();
    start_at(begin_);
    return ReadStatus::round_ended;
  }
  if (playing) pacer_->end();
  if (playing && !stay_at_end_) return ReadStatus::finished;
  if (!std::exchange(flushed_, true)) sink.flush();
  pacer_->wait_for_change(timeout);
  return ReadStatus::idle;
}

void SessionSource::hand_over(SampleSink& sink) {
  const Input& input = inputs_.at(next_->channel->id);
  auto sample = parse_waiting(input, next_->message);
  next_.reset();
  if (sample) {
    sink.receive(std::move(*sample));
  } else {
    log("replay")->warn("{} on {}: {}; left out", name_, input.info.topic, sample.error().message);
  }
}

Result<ReadStatus> SessionSource::read(SampleSink& sink, std::chrono::milliseconds timeout) {
  for (int count = 0; count < kMessagesPerRead; ++count) {
    if (const auto place = pacer_->take_seek()) {
      start_at(*place);
      return ReadStatus::jumped;
    }
    if (!read_next()) return at_end(sink, timeout);
    const HostTime due = mcap::host_time_from(next_->message.log_time_ns);
    if (count > 0 && pacer_->until_due(due) > Duration{0}) return ReadStatus::more;
    if (pacer_->wait_until_due(due, timeout) > Duration{0}) return ReadStatus::idle;
    if (pacer_->has_seek()) continue;
    pacer_->reached(due);
    hand_over(sink);
  }
  return ReadStatus::more;
}

}  // namespace roseau::replay
