// The Foxglove WebSocket protocol (docs/spec of foxglove/ws-protocol), the server's side: what is written to and read from
// the wire, without a socket. Text messages are JSON with an "op", binary ones start with an opcode byte; little-endian.
//
// Both names of the protocol are spoken; they are the same on the wire.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/result.h"
#include "core/time.h"

namespace roseau::display {

using ChannelId = std::uint32_t;
using SubscriptionId = std::uint32_t;  // chosen by the client

inline constexpr std::string_view kSdkSubprotocol = "foxglove.sdk.v1";
inline constexpr std::string_view kWebSocketSubprotocol = "foxglove.websocket.v1";

/// The first of the names in a Sec-WebSocket-Protocol header (a comma-separated list) that we speak.
std::optional<std::string> choose_subprotocol(std::string_view offered);

// ---------------------------------------------------------------------------------------------------------------------
// Server to client

struct ServerInfo {
  std::string name;
  std::string session_id;  // a client that reconnects and finds another one forgets what it knew
  std::vector<std::pair<std::string, std::string>> metadata;
  /// In replay: begin and end of the recording. The time is the recording's then, and clients may drive it.
  std::optional<std::pair<HostTime, HostTime>> data_range;
};
std::string server_info_message(const ServerInfo& info);

struct Channel {
  ChannelId id = 0;
  std::string topic;
  std::string encoding = "protobuf";
  std::string schema_name;
  std::string schema;  // as on the wire: base64 of a FileDescriptorSet for protobuf, the text itself for jsonschema
  std::string schema_encoding = "protobuf";
};
std::string advertise_message(std::span<const Channel> channels);

enum class StatusLevel : std::uint8_t { info = 0, warning = 1, error = 2 };
std::string status_message(StatusLevel level, std::string_view message);

/// Parameters are constants about the server: a client may read them, not set them.
using Parameters = std::vector<std::pair<std::string, std::string>>;
std::string parameter_values_message(const Parameters& parameters, const std::optional<std::string>& request_id);

/// The 13 bytes before a message's payload.
std::string message_data_header(SubscriptionId subscription, HostTime log_time);
std::string time_message(HostTime time);

enum class PlaybackStatus : std::uint8_t { playing = 0, paused = 1, buffering = 2, ended = 3 };
struct PlaybackState {
  PlaybackStatus status = PlaybackStatus::playing;
  HostTime time;
  float speed = 1;         // times real time
  bool did_seek = false;   // what was shown before belongs to another place: clients clear their panels
  std::string request_id;  // of the request that this answers; empty: nobody asked
};
std::string playback_state_message(const PlaybackState& state);

std::string base64(std::string_view bytes);

// ---------------------------------------------------------------------------------------------------------------------
// Client to server

struct Subscribe {
  std::vector<std::pair<SubscriptionId, ChannelId>> subscriptions;
};
struct Unsubscribe {
  std::vector<SubscriptionId> subscriptions;
};
struct GetParameters {
  std::vector<std::string> names;  // empty: all
  std::optional<std::string> request_id;
};
/// A request of the protocol that this server does not offer; `what` says so in words.
struct NotOffered {
  std::string what;
};
using ClientMessage = std::variant<Subscribe, Unsubscribe, GetParameters, NotOffered>;

/// An Error (words for the client) when the text is no JSON object, has no known op, or a field is missing or of the wrong
/// type.
Result<ClientMessage> parse_client_text(std::string_view text);
struct PlaybackControl {
  bool play = true;  // false: pause
  float speed = 1;   // above 0, finite
  std::optional<HostTime> seek;
  std::string request_id;  // at most kMostRequestIdBytes
};
inline constexpr std::size_t kMostRequestIdBytes = 1024;

/// The one binary request that is offered, in replay. An Error (words for the client) when the bytes are too few, a field has
/// no meaning (`invalid_argument`), or they ask for something else of the protocol (`unsupported`). Bytes behind the request
/// are ignored: newer clients may say more.
Result<PlaybackControl> parse_client_binary(std::string_view bytes);

}  // namespace roseau::display
