#include "recorder/tools/export/session_part.h"

#include <fmt/format.h>

#include "recorder/tools/selection/civil_time.h"

namespace roseau::recorder {

namespace {
constexpr std::size_t kMostDamageSaid = 100;
constexpr std::uint64_t kProgressInterval = 64;
}  // namespace

Result<SessionPart> SessionPart::open(const std::filesystem::path& path, const SelectionOptions& options) {
  SessionPart part;
  part.path_ = path;
  auto reader = mcap::IndexedReader::open(path);
  if (!reader) return reader.error();
  part.reader_ = std::move(*reader);
  auto info = read_session_info(*part.reader_);
  if (!info) return info.error().with_context(path.string());
  part.info_ = std::move(*info);
  const auto& index = part.reader_->index();
  auto selection = select(options, index, part.info_.utc_minus_host_time);
  if (!selection) return selection.error().with_context(path.string());
  part.selection_ = std::move(*selection);
  part.begin_ = mcap::host_time_from(index.statistics.message_start_time_ns);
  part.end_ = mcap::host_time_from(index.statistics.message_end_time_ns);
  part.report_.damage = index.damage;
  for (const auto& [id, channel] : index.catalog.channels()) {
    auto stream = mcap::stream_info_from(channel, index.catalog.schema_of(channel));
    if (stream) part.table_->add(*stream);
    if (!part.selection_.holds_channel(id)) continue;
    if (!stream) {
      part.report_.left_out.push_back(stream.error().message);
      continue;
    }
    const auto kind = sample_kind_from_string(stream->kind);
    ROSEAU_CHECK(kind.has_value());  // stream_info_from gives only kinds that there are
    const auto count = index.statistics.channel_message_counts.find(id);
    part.streams_[id] = {std::move(*stream), *kind, count == index.statistics.channel_message_counts.end() ? 0 : count->second};
  }
  return part;
}

void SessionPart::keep(const std::function<bool(const Stream&)>& wanted) {
  std::erase_if(streams_, [&wanted](const auto& entry) { return !wanted(entry.second); });
}

std::string SessionPart::utc(HostTime time, int digits) const {
  return info_.utc_minus_host_time ? utc_text(to_ns(time + *info_.utc_minus_host_time), digits) : std::string();
}

void SessionPart::damaged(std::string sentence) {
  if (report_.damage.size() < kMostDamageSaid) report_.damage.push_back(std::move(sentence));
}

Result<void> SessionPart::for_each(const TakeMessage& take, const ToolProgress& progress) {
  mcap::MessageQuery query{.channels = std::vector<std::uint16_t>{},
                           .start_time_ns = selection_.first_time_ns,
                           .end_time_ns = selection_.last_time_ns};
  for (const auto& [id, stream] : streams_) query.channels->push_back(id);
  const HostTime from = std::max(begin_, mcap::host_time_from(selection_.first_time_ns));
  const HostTime to = std::min(end_, mcap::host_time_from(selection_.last_time_ns));
  auto messages = reader_->messages(query);
  for (std::uint64_t count = 0;; ++count) {
    const auto read = messages.next();
    if (!read) {
      damaged(read.error().message);
      continue;
    }
    if (!*read) return {};
    const mcap::Message& message = (*read)->message;
    SampleHeader known;
    known.sequence = message.sequence;
    known.arrival_time = mcap::host_time_from(message.log_time_ns);
    known.sample_time = mcap::host_time_from(message.publish_time_ns);
    if (auto taken = take(message.channel_id, message, known); !taken) return taken;
    if (!progress || count % kProgressInterval != 0 || to <= from) continue;
    if (!progress(to_seconds(known.arrival_time - from) / to_seconds(to - from))) {
      report_.stopped = true;
      return {};
    }
  }
}

Result<void> SessionPart::for_each_sample(const std::function<Result<void>(std::uint16_t, const Sample&)>& take,
                                          const ToolProgress& progress) {
  return for_each(
      [&](std::uint16_t channel, const mcap::Message& message, const SampleHeader& known) -> Result<void> {
        const Stream& stream = streams_.at(channel);
        if (stream.kind == SampleKind::frame) {
          const auto view = schema::parse_frame(message.data, known);
          if (!view) {
            damaged(fmt::format("{}, sequence {}: {}", stream.info.topic, message.sequence, view.error().message));
            return {};
          }
          return take(channel, Sample{view->header, Frame{.width = view->width,
                                                          .height = view->height,
                                                          .stride = view->stride,
                                                          .format = view->format,
                                                          .exposure_duration = view->exposure_duration}});
        }
        const auto sample = schema::parse(stream.kind, message.data, known, *table_);
        if (sample) return take(channel, *sample);
        damaged(fmt::format("{}, sequence {}: {}", stream.info.topic, message.sequence, sample.error().message));
        return {};
      },
      progress);
}

Result<void> SessionPart::for_each_frame(const std::function<Result<void>(std::uint16_t, const schema::FrameView&)>& take,
                                         const ToolProgress& progress) {
  return for_each(
      [&](std::uint16_t channel, const mcap::Message& message, const SampleHeader& known) -> Result<void> {
        const auto view = schema::parse_frame(message.data, known);
        if (view) return take(channel, *view);
        damaged(fmt::format("{}, sequence {}: {}", streams_.at(channel).info.topic, message.sequence, view.error().message));
        return {};
      },
      progress);
}

}  // namespace roseau::recorder
