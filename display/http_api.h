// The JSON side of the server: what the page asks for and what it may do. Texts in, values out; no socket.
//
//   GET  /api/state           the display's own state (also pushed on the channel /display/state)
//   GET  /api/recording       what the recorder does, as of the last second: phase, cause, file, rate, free time, copy, battery
//   GET  /api/streams         what every stream is: topic, kind, role, device, metadata, channel
//   GET  /api/marks           what was marked when the session that is replayed was recorded
//   GET  /api/history?channel=ID   what is kept of a channel (hub.h says in what form)
//   POST /api/action   {"kind": "mark"|"note"|"add_target"|"remove_target"|"start_recording"|"stop_recording"|"trigger",
//                       "text": "...", "camera": "camera0", "region": {"x": 0, "y": 0, "width": 0, "height": 0}}
//   POST /api/player   {"command": "play"|"pause"|"speed"|"seek", "speed": 2, "time_s": 12.5}
//                      speed null: as fast as possible; time_s: seconds since the begin of the session
//
// A POST carries Content-Type application/json (a foreign page cannot send that without asking first) and comes from the same
// origin or from loopback; the answer is {} or {"error": "what is wrong and what to do"}.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/player_control.h"
#include "core/result.h"
#include "core/sample.h"
#include "core/stream.h"
#include "display/foxglove_protocol.h"
#include "display/hub.h"

namespace roseau::display {

/// Checks kind, lengths (texts up to 500 bytes) and region; whether camera and target exist is for the pipeline to say.
Result<OperatorAction> parse_action(std::string_view body);

/// Times real time; what is asked for above it is as fast as possible, and told to viewers as this.
inline constexpr double kFastestSpeed = 1000;

struct PlayerCommand {
  enum class Kind : std::uint8_t { play, pause, speed, seek };
  Kind kind = Kind::play;
  double speed = 1;   // infinity: as fast as possible
  double time_s = 0;  // seek: since the session's begin
};
Result<PlayerCommand> parse_player_command(std::string_view body);
void apply(const PlayerCommand& command, PlayerControl& player);

/// A camera's picture as it is tracked: what the regions and points drawn over its preview are measured in.
struct PictureSize {
  std::string topic;  // of the preview
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
};

struct DisplayState {
  HostTime newest;  // log time of the newest sample seen
  HubCounters viewers;
  std::uint64_t messages_dropped = 0;  // not taken from the pipeline
  std::vector<PictureSize> pictures;
  std::optional<PlayerState> player;
};
std::string state_json(const DisplayState& state);
std::string streams_json(const StreamTable& streams);
std::string marks_json(const std::vector<RecordedMark>& marks);
std::string recording_json(const Health& health);
std::string error_json(std::string_view message);

/// The value of `name` in the target's query as a channel number.
std::optional<ChannelId> channel_in_query(std::string_view target);

}  // namespace roseau::display
