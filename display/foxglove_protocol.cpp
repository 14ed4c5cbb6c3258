#include "display/foxglove_protocol.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace roseau::display {

namespace {

using nlohmann::json;

constexpr std::array<std::string_view, 2> kSubprotocols = {kSdkSubprotocol, kWebSocketSubprotocol};
constexpr char kMessageDataOpcode = 0x01;
constexpr char kTimeOpcode = 0x02;
constexpr char kPlaybackStateOpcode = 0x05;
constexpr int kPlaybackControlOpcode = 0x03;  // client to server

/// Text that may hold anything a client sent: what is no UTF-8 is replaced, never thrown over.
std::string dump(const json& object) { return object.dump(-1, ' ', false, json::error_handler_t::replace); }

template <class Unsigned>
void append_little_endian(std::string& out, Unsigned value) {
  for (std::size_t byte = 0; byte < sizeof(Unsigned); ++byte) out.push_back(static_cast<char>((value >> (8 * byte)) & 0xff));
}

/// Takes a number off the front; there must be enough bytes.
template <class Unsigned>
Unsigned take_little_endian(std::string_view& bytes) {
  std::uint64_t value = 0;
  for (std::size_t byte = 0; byte < sizeof(Unsigned); ++byte) {
    value |= std::uint64_t{static_cast<unsigned char>(bytes[byte])} << (8 * byte);
  }
  bytes.remove_prefix(sizeof(Unsigned));
  return static_cast<Unsigned>(value);
}

json time_object(HostTime time) {
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  return {{"sec", to_ns(time) / kSecond_ns}, {"nsec", to_ns(time) % kSecond_ns}};
}

Error malformed(const std::string& what) { return {ErrorCode::invalid_argument, what}; }

std::optional<std::uint32_t> as_id(const json& value) {
  if (!value.is_number_unsigned()) return std::nullopt;
  const auto number = value.get<std::uint64_t>();
  if (number > std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
  return static_cast<std::uint32_t>(number);
}

const json* array_field(const json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_array() ? &*found : nullptr;
}

std::optional<std::string> optional_string(const json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_string()) return std::nullopt;
  return found->get<std::string>();
}

Result<ClientMessage> parse_subscribe(const json& object) {
  const json* list = array_field(object, "subscriptions");
  if (list == nullptr) return malformed("subscribe needs an array \"subscriptions\"");
  Subscribe message;
  for (const json& entry : *list) {
    if (!entry.is_object()) return malformed("subscribe: each subscription is an object with id and channelId");
    const auto id = as_id(entry.value("id", json()));
    const auto channel = as_id(entry.value("channelId", json()));
    if (!id || !channel) return malformed("subscribe: id and channelId are integers from 0 to 4294967295");
    message.subscriptions.emplace_back(*id, *channel);
  }
  return ClientMessage(std::move(message));
}

Result<ClientMessage> parse_unsubscribe(const json& object) {
  const json* list = array_field(object, "subscriptionIds");
  if (list == nullptr) return malformed("unsubscribe needs an array \"subscriptionIds\"");
  Unsubscribe message;
  for (const json& entry : *list) {
    const auto id = as_id(entry);
    if (!id) return malformed("unsubscribe: subscriptionIds are integers from 0 to 4294967295");
    message.subscriptions.push_back(*id);
  }
  return ClientMessage(std::move(message));
}

Result<ClientMessage> parse_get_parameters(const json& object) {
  const json* list = array_field(object, "parameterNames");
  if (list == nullptr) return malformed("getParameters needs an array \"parameterNames\"");
  GetParameters message{.names = {}, .request_id = optional_string(object, "id")};
  for (const json& entry : *list) {
    if (!entry.is_string()) return malformed("getParameters: parameterNames are strings");
    message.names.push_back(entry.get<std::string>());
  }
  return ClientMessage(std::move(message));
}

/// command u8, speed f32, had seek u8, seek time u64, length of the id u32, id.
Result<PlaybackControl> parse_playback_control(std::string_view payload) {
  constexpr std::size_t kFixedBytes = 1 + 4 + 1 + 8 + 4;
  if (payload.size() < kFixedBytes) {
    return malformed("playback control: " + std::to_string(payload.size()) + " bytes behind the opcode, at least " +
                     std::to_string(kFixedBytes) + " are needed");
  }
  PlaybackControl control;
  const auto command = take_little_endian<std::uint8_t>(payload);
  if (command > 1) return malformed("playback control: command " + std::to_string(command) + " is neither 0 play nor 1 pause");
  control.play = command == 0;
  control.speed = std::bit_cast<float>(take_little_endian<std::uint32_t>(payload));
  if (!(control.speed > 0) || !std::isfinite(control.speed)) return malformed("playback control: the speed is not above 0");
  const bool had_seek = take_little_endian<std::uint8_t>(payload) != 0;
  const auto seek_ns = take_little_endian<std::uint64_t>(payload);
  // The far future is the end of the session like any time behind it.
  constexpr std::uint64_t kMost_ns = std::numeric_limits<std::int64_t>::max();
  if (had_seek) control.seek = host_time_from_ns(static_cast<std::int64_t>(std::min(seek_ns, kMost_ns)));
  const auto id_bytes = take_little_endian<std::uint32_t>(payload);
  if (id_bytes > payload.size()) return malformed("playback control: the request's id is cut off");
  if (id_bytes > kMostRequestIdBytes) return malformed("playback control: the request's id is longer than 1024 bytes");
  control.request_id = payload.substr(0, id_bytes);
  return control;
}

}  // namespace

std::optional<std::string> choose_subprotocol(std::string_view offered) {
  while (!offered.empty()) {
    const std::size_t comma = std::min(offered.find(','), offered.size());
    std::string_view name = offered.substr(0, comma);
    offered.remove_prefix(std::min(comma + 1, offered.size()));
    while (!name.empty() && (name.front() == ' ' || name.front() == '\t')) name.remove_prefix(1);
    while (!name.empty() && (name.back() == ' ' || name.back() == '\t')) name.remove_suffix(1);
    if (std::ranges::find(kSubprotocols, name) != kSubprotocols.end()) return std::string(name);
  }
  return std::nullopt;
}

std::string server_info_message(const ServerInfo& info) {
  json capabilities = json::array({"parameters"});
  if (info.data_range) {
    capabilities.push_back("time");
    capabilities.push_back("playbackControl");
  }
  json metadata = json::object();
  for (const auto& [key, value] : info.metadata) metadata[key] = value;
  json message = {{"op", "serverInfo"},           {"name", info.name},
                  {"capabilities", capabilities}, {"supportedEncodings", json::array()},
                  {"metadata", metadata},         {"sessionId", info.session_id}};
  if (info.data_range) {
    message["dataStartTime"] = time_object(info.data_range->first);
    message["dataEndTime"] = time_object(info.data_range->second);
  }
  return dump(message);
}

std::string advertise_message(std::span<const Channel> channels) {
  json list = json::array();
  for (const Channel& channel : channels) {
    list.push_back({{"id", channel.id},
                    {"topic", channel.topic},
                    {"encoding", channel.encoding},
                    {"schemaName", channel.schema_name},
                    {"schema", channel.schema},
                    {"schemaEncoding", channel.schema_encoding}});
  }
  return dump({{"op", "advertise"}, {"channels", std::move(list)}});
}

std::string status_message(StatusLevel level, std::string_view message) {
  return dump({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", std::string(message)}});
}

std::string parameter_values_message(const Parameters& parameters, const std::optional<std::string>& request_id) {
  json list = json::array();
  for (const auto& [name, value] : parameters) list.push_back({{"name", name}, {"value", value}});
  json message = {{"op", "parameterValues"}, {"parameters", std::move(list)}};
  if (request_id) message["id"] = *request_id;
  return dump(message);
}

std::string message_data_header(SubscriptionId subscription, HostTime log_time) {
  std::string header(1, kMessageDataOpcode);
  append_little_endian(header, subscription);
  append_little_endian(header, static_cast<std::uint64_t>(to_ns(log_time)));
  return header;
}

std::string time_message(HostTime time) {
  std::string message(1, kTimeOpcode);
  append_little_endian(message, static_cast<std::uint64_t>(to_ns(time)));
  return message;
}

std::string playback_state_message(const PlaybackState& state) {
  std::string message(1, kPlaybackStateOpcode);
  message.push_back(static_cast<char>(state.status));
  append_little_endian(message, static_cast<std::uint64_t>(to_ns(state.time)));
  append_little_endian(message, std::bit_cast<std::uint32_t>(state.speed));
  message.push_back(state.did_seek ? 1 : 0);
  append_little_endian(message, static_cast<std::uint32_t>(state.request_id.size()));
  return message + state.request_id;
}

std::string base64(std::string_view bytes) {
  static constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto byte_at = [&](std::size_t index) {
    return index < bytes.size() ? std::uint32_t{static_cast<unsigned char>(bytes[index])} : 0U;
  };
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t start = 0; start < bytes.size(); start += 3) {
    const std::uint32_t group = byte_at(start) << 16 | byte_at(start + 1) << 8 | byte_at(start + 2);
    const std::size_t digits = std::min<std::size_t>(bytes.size() - start, 3) + 1;
    for (std::size_t digit = 0; digit < 4; ++digit) {
      out.push_back(digit < digits ? kAlphabet[(group >> (18 - 6 * digit)) & 0x3f] : '=');
    }
  }
  return out;
}

Result<ClientMessage> parse_client_text(std::string_view text) {
  const json object = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!object.is_object()) return malformed("this is not a JSON object; see the Foxglove WebSocket protocol");
  const auto op = optional_string(object, "op");
  if (!op) return malformed("the message has no \"op\"; see the Foxglove WebSocket protocol");
  if (*op == "subscribe") return parse_subscribe(object);
  if (*op == "unsubscribe") return parse_unsubscribe(object);
  if (*op == "getParameters") return parse_get_parameters(object);
  static constexpr std::array<std::string_view, 9> kKnown = {"advertise",
                                                             "unadvertise",
                                                             "setParameters",
                                                             "subscribeParameterUpdates",
                                                             "unsubscribeParameterUpdates",
                                                             "subscribeConnectionGraph",
                                                             "unsubscribeConnectionGraph",
                                                             "fetchAsset",
                                                             "playbackControl"};
  if (std::ranges::find(kKnown, *op) != kKnown.end()) return ClientMessage(NotOffered{*op + " is not offered by this server"});
  constexpr std::size_t kShown = 40;
  return malformed("unknown op \"" + op->substr(0, kShown) + "\"; see the Foxglove WebSocket protocol");
}

Result<PlaybackControl> parse_client_binary(std::string_view bytes) {
  if (bytes.empty()) return malformed("an empty binary message means nothing");
  const int opcode = static_cast<unsigned char>(bytes.front());
  switch (opcode) {
    case 0x01:
      return Error{ErrorCode::unsupported, "publishing from clients is not offered by this server"};
    case 0x02:
      return Error{ErrorCode::unsupported, "services are not offered by this server; actions are POST /api/action"};
    case kPlaybackControlOpcode:
      return parse_playback_control(bytes.substr(1));
    default:
      return malformed("unknown binary opcode " + std::to_string(opcode));
  }
}

}  // namespace roseau::display
