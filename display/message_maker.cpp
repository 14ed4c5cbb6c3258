#include "display/message_maker.h"

#include <utility>

#include "core/log.h"
#include "schema/conversion.h"

namespace roseau::display {

MessageMaker::MessageMaker(const StreamTable& streams, const Demand& demand, PreviewOptions options)
    : streams_(streams), demand_(demand), options_(options), encoder_(options.max_width_px, options.quality) {}

std::vector<MadeMessage> MessageMaker::make(const Sample& sample, HostTime log_time, WallTime now) {
  std::vector<MadeMessage> made;
  const StreamId stream = sample.header.stream;
  if (sample.kind() == SampleKind::frame) {
    note_size(stream, std::get<Frame>(sample.payload));
    if (demand_.wanted(preview_channel_of(stream)) && preview_is_due(stream, now)) {
      waiting_.erase(stream);
      if (auto preview = make_preview(sample, log_time)) made.push_back(std::move(*preview));
    } else {
      waiting_.insert_or_assign(stream, Waiting{sample, log_time});
    }
    if (!demand_.wanted(channel_of(stream))) return made;
  }
  auto message = std::make_shared<std::vector<std::byte>>();
  schema::serialize(sample, streams_, *message);
  made.push_back({channel_of(stream), log_time, std::move(message)});
  return made;
}

std::vector<MadeMessage> MessageMaker::make_waiting(WallTime now) {
  std::vector<MadeMessage> made;
  std::erase_if(waiting_, [&](const auto& entry) {
    const auto& [stream, waiting] = entry;
    if (!demand_.wanted(preview_channel_of(stream)) || !preview_is_due(stream, now)) return false;
    if (auto preview = make_preview(waiting.sample, waiting.log_time)) made.push_back(std::move(*preview));
    return true;
  });
  return made;
}

std::optional<PictureSize> MessageMaker::take_new_picture_size() { return std::exchange(new_size_, std::nullopt); }

bool MessageMaker::preview_is_due(StreamId stream, WallTime now) {
  const auto interval = std::chrono::duration_cast<WallTime::duration>(std::chrono::duration<double>(1 / options_.max_rate_hz));
  const auto next = next_preview_.try_emplace(stream, now).first;
  // A camera at just this rate jitters around it: some grace keeps every one of its pictures, `next` keeps the mean rate.
  if (now + interval / 4 < next->second) return false;
  next->second = std::max(next->second + interval, now);
  return true;
}

std::optional<MadeMessage> MessageMaker::make_preview(const Sample& sample, HostTime log_time) {
  const StreamId stream = sample.header.stream;
  const auto jpeg = encoder_.encode(std::get<Frame>(sample.payload));
  if (!jpeg) {
    log("display")->error("{}: {}", streams_.info(stream).topic, jpeg.error().message);
    return std::nullopt;
  }
  auto message = std::make_shared<std::vector<std::byte>>();
  const auto bytes = std::as_bytes(std::span(jpeg->data(), jpeg->size()));
  schema::serialize_compressed_image(sample.header, streams_.info(stream).device, "jpeg", bytes, *message);
  return MadeMessage{preview_channel_of(stream), log_time, std::move(message)};
}

void MessageMaker::note_size(StreamId stream, const Frame& frame) {
  PictureSize& size = sizes_[stream];
  if (size.width_px == frame.width && size.height_px == frame.height) return;
  size = {streams_.info(stream).topic + "/preview", frame.width, frame.height};
  new_size_ = size;
}

}  // namespace roseau::display
