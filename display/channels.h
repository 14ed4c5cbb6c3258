// Channels: how streams appear to live viewers. Every stream is one channel; every camera has a second one with small JPEGs.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "core/stream.h"
#include "display/foxglove_protocol.h"

namespace roseau::display {

inline constexpr std::uint32_t kStreamCount = 1U << 16;
inline constexpr ChannelId kStateChannel = 0;  // the display's own state, JSON
inline constexpr std::string_view kStateTopic = "/display/state";

constexpr ChannelId channel_of(StreamId stream) { return ChannelId{stream} + 1; }
constexpr ChannelId preview_channel_of(StreamId stream) { return kStreamCount + ChannelId{stream} + 1; }
inline constexpr ChannelId kChannelCount = 2 * kStreamCount + 1;

/// What of a channel is kept, so that a viewer that comes later is complete at once.
struct Retention {
  std::size_t on_subscribe = 0;         // newest messages sent to whoever subscribes
  std::chrono::seconds for_history{0};  // how far back GET /api/history reaches
};

struct ChannelSetup {
  Channel channel;
  Retention retention;
  bool conflated = false;  // only the newest message matters to a viewer
};

/// The channel of a stream, and of a camera's small pictures.
ChannelSetup stream_channel(StreamId id, const StreamInfo& info);
ChannelSetup preview_channel(StreamId id, const StreamInfo& info);
ChannelSetup state_channel();
bool is_camera(const StreamInfo& info);

/// Which channels somebody is subscribed to. Written by the server's thread, read by any.
class Demand {
 public:
  bool wanted(ChannelId channel) const { return (*flags_)[channel].load(std::memory_order_relaxed); }
  void set(ChannelId channel, bool wanted) { (*flags_)[channel].store(wanted, std::memory_order_relaxed); }

 private:
  using Flags = std::array<std::atomic<bool>, kChannelCount>;
  std::unique_ptr<Flags> flags_ = std::make_unique<Flags>();
};

}  // namespace roseau::display
