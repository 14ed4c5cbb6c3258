// MessageMaker: a sample into the messages viewers get: its own message, and for a frame the small picture.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/sample.h"
#include "core/stream.h"
#include "display/channels.h"
#include "display/http_api.h"
#include "display/outbox.h"
#include "display/preview.h"

namespace roseau::display {

struct PreviewOptions {
  std::uint32_t max_width_px = 960;
  int quality = 80;
  double max_rate_hz = 30;
};

struct MadeMessage {
  ChannelId channel = 0;
  HostTime log_time;
  SharedBytes payload;
};

/// Used by one thread.
class MessageMaker {
 public:
  using WallTime = std::chrono::steady_clock::time_point;

  MessageMaker(const StreamTable& streams, const Demand& demand, PreviewOptions options);

  /// None, one, or for a frame watched both ways two. `now` only thins out the small pictures.
  std::vector<MadeMessage> make(const Sample& sample, HostTime log_time, WallTime now);

  /// Small pictures left out before that are wanted and due by now, unless newer ones came: the last picture of all is always
  /// shown, and a paused replay's to whoever comes later.
  std::vector<MadeMessage> make_waiting(WallTime now);

  /// Nothing of before is shown any more.
  void forget() { waiting_.clear(); }

  /// Set after the first picture of a camera, and when its size changes.
  std::optional<PictureSize> take_new_picture_size();

 private:
  bool preview_is_due(StreamId stream, WallTime now);
  std::optional<MadeMessage> make_preview(const Sample& sample, HostTime log_time);
  void note_size(StreamId stream, const Frame& frame);

  const StreamTable& streams_;
  const Demand& demand_;
  const PreviewOptions options_;
  PreviewEncoder encoder_;
  std::map<StreamId, WallTime> next_preview_;
  struct Waiting {
    Sample sample;
    HostTime log_time;
  };
  std::map<StreamId, Waiting> waiting_;  // the newest picture of each camera, while no small one was made of it
  std::map<StreamId, PictureSize> sizes_;
  std::optional<PictureSize> new_size_;
};

}  // namespace roseau::display
