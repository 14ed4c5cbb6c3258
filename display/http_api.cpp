#include "display/http_api.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "display/channels.h"

namespace roseau::display {

namespace {

using nlohmann::json;

constexpr std::size_t kLongestText_bytes = 500;

constexpr std::array<std::pair<std::string_view, OperatorAction::Kind>, 7> kActions = {{
    {"mark", OperatorAction::Kind::mark},
    {"note", OperatorAction::Kind::note},
    {"add_target", OperatorAction::Kind::add_target},
    {"remove_target", OperatorAction::Kind::remove_target},
    {"start_recording", OperatorAction::Kind::start_recording},
    {"stop_recording", OperatorAction::Kind::stop_recording},
    {"trigger", OperatorAction::Kind::trigger},
}};

Error wrong(const std::string& what) { return {ErrorCode::invalid_argument, what}; }

std::string dump(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

/// A string field, "" when absent.
Result<std::string> text_field(const json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end()) return std::string();
  if (!found->is_string()) return wrong(std::string("\"") + name + "\" is not a text");
  auto text = found->get<std::string>();
  if (text.size() > kLongestText_bytes) return wrong(std::string("\"") + name + "\" is longer than 500 bytes");
  return text;
}

Result<ImageRect> region_field(const json& object) {
  const auto found = object.find("region");
  if (found == object.end() || !found->is_object()) return wrong("\"region\" is missing: draw a rectangle around the target");
  std::array<double, 4> values{};
  static constexpr std::array<const char*, 4> kNames = {"x", "y", "width", "height"};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto value = found->find(kNames[i]);
    if (value == found->end() || !value->is_number()) return wrong(std::string("\"region.") + kNames[i] + "\" is not a number");
    values[i] = value->get<double>();
    if (!std::isfinite(values[i])) return wrong(std::string("\"region.") + kNames[i] + "\" is not finite");
  }
  const ImageRect region{values[0], values[1], values[2], values[3]};
  if (region.width < 1 || region.height < 1) return wrong("the region is empty: draw a larger rectangle");
  return region;
}

Result<void> require_fields(const OperatorAction& action) {
  using Kind = OperatorAction::Kind;
  if (action.kind == Kind::add_target && action.camera.empty()) return wrong("\"camera\" is missing: say in whose picture");
  if ((action.kind == Kind::remove_target || action.kind == Kind::note) && action.text.empty()) {
    return wrong(action.kind == Kind::note ? "\"text\" is missing: an empty note says nothing"
                                           : "\"text\" is missing: the name of the target to remove");
  }
  return {};
}

json player_json(const PlayerState& state) {
  return {{"playing", state.playing},
          {"ended", state.ended},
          {"speed", std::isfinite(state.speed) ? json(state.speed) : json(nullptr)},
          {"position_ns", std::to_string(to_ns(state.position))},
          {"begin_ns", std::to_string(to_ns(state.begin))},
          {"end_ns", std::to_string(to_ns(state.end))},
          {"jumps", state.jumps}};
}

std::string_view to_string(StreamRole role) {
  static constexpr std::array<std::string_view, 3> kNames = {"raw", "derived", "health"};
  return kNames.at(static_cast<std::size_t>(role));
}

Result<PlayerCommand> parse_seek(const json& object) {
  const auto time = object.find("time_s");
  if (time == object.end() || !time->is_number() || !std::isfinite(time->get<double>())) {
    return wrong("\"time_s\" is missing or not a number: seconds since the begin of the session");
  }
  return PlayerCommand{.kind = PlayerCommand::Kind::seek, .time_s = time->get<double>()};
}

}  // namespace

Result<OperatorAction> parse_action(std::string_view body) {
  const json object = json::parse(body, nullptr, /*allow_exceptions=*/false);
  if (!object.is_object()) return wrong("the body is no JSON object");
  const auto kind_name = text_field(object, "kind");
  if (!kind_name) return kind_name.error();
  const auto* kind = std::ranges::find(kActions, std::string_view(*kind_name), [](const auto& entry) { return entry.first; });
  if (kind == kActions.end()) {
    return wrong("\"kind\" is one of mark, note, add_target, remove_target, start_recording, stop_recording, trigger");
  }
  OperatorAction action{.kind = kind->second};
  const auto text = text_field(object, "text");
  if (!text) return text.error();
  const auto camera = text_field(object, "camera");
  if (!camera) return camera.error();
  action.text = *text;
  action.camera = *camera;
  if (const auto complete = require_fields(action); !complete) return complete.error();
  if (action.kind == OperatorAction::Kind::add_target) {
    const auto region = region_field(object);
    if (!region) return region.error();
    action.region = *region;
  }
  return action;
}

Result<PlayerCommand> parse_player_command(std::string_view body) {
  const json object = json::parse(body, nullptr, /*allow_exceptions=*/false);
  if (!object.is_object()) return wrong("the body is no JSON object");
  const auto command = text_field(object, "command");
  if (!command) return command.error();
  if (*command == "play") return PlayerCommand{PlayerCommand::Kind::play};
  if (*command == "pause") return PlayerCommand{PlayerCommand::Kind::pause};
  if (*command == "seek") return parse_seek(object);
  if (*command != "speed") return wrong("\"command\" is one of play, pause, speed, seek");
  const auto speed = object.find("speed");
  if (speed == object.end()) return wrong("\"speed\" is missing: times real time, or null for as fast as possible");
  if (speed->is_null()) return PlayerCommand{PlayerCommand::Kind::speed, std::numeric_limits<double>::infinity()};
  if (!speed->is_number()) return wrong("\"speed\" is not a number");
  const auto value = speed->get<double>();
  if (!(value > 0) || value > kFastestSpeed) return wrong("\"speed\" is above 0 and at most 1000; null is as fast as possible");
  return PlayerCommand{PlayerCommand::Kind::speed, value};
}

void apply(const PlayerCommand& command, PlayerControl& player) {
  switch (command.kind) {
    case PlayerCommand::Kind::play:
      player.play();
      return;
    case PlayerCommand::Kind::pause:
      player.pause();
      return;
    case PlayerCommand::Kind::speed:
      player.set_speed(command.speed);
      return;
    case PlayerCommand::Kind::seek: {
      const PlayerState state = player.state();
      // Cut to the session before it becomes nanoseconds, which hold no more than 292 years.
      const double time_s = std::clamp(command.time_s, 0.0, to_seconds(state.end - state.begin));
      player.seek(state.begin + from_seconds(time_s));
      return;
    }
  }
}

std::string state_json(const DisplayState& state) {
  json pictures = json::array();
  for (const PictureSize& picture : state.pictures) {
    pictures.push_back({{"topic", picture.topic}, {"width_px", picture.width_px}, {"height_px", picture.height_px}});
  }
  return dump({{"time_ns", std::to_string(to_ns(state.newest))},
               {"clients", state.viewers.clients},
               {"images_dropped", state.viewers.images_dropped},
               {"messages_dropped", state.messages_dropped},
               {"slow_clients", state.viewers.slow_clients},
               {"pictures", std::move(pictures)},
               {"player", state.player ? player_json(*state.player) : json(nullptr)}});
}

std::string streams_json(const StreamTable& streams) {
  json list = json::array();
  const std::size_t count = streams.size();
  for (std::size_t index = 0; index < count; ++index) {
    const auto id = static_cast<StreamId>(index);
    const StreamInfo& info = streams.info(id);
    list.push_back({{"channel", channel_of(id)},
                    {"topic", info.topic},
                    {"kind", info.kind},
                    {"role", to_string(info.role)},
                    {"device", info.device},
                    {"metadata", info.metadata}});
  }
  return dump({{"streams", std::move(list)}});
}

std::string marks_json(const std::vector<RecordedMark>& marks) {
  json list = json::array();
  for (const RecordedMark& mark : marks) list.push_back({{"time_ns", std::to_string(to_ns(mark.time))}, {"text", mark.text}});
  return dump({{"marks", std::move(list)}});
}

std::string recording_json(const Health& health) {
  json copy = nullptr;
  if (!health.copy.directory.empty()) {
    copy = {{"directory", health.copy.directory},
            {"state", to_string(health.copy.state)},
            {"message", health.copy.message},
            {"verified_bytes", health.copy.verified_bytes},
            {"behind_bytes", health.copy.behind_bytes}};
  }
  return dump({{"phase", to_string(health.recording_phase)},
               {"cause", health.recording_cause},
               {"ends_s", health.recording_ends_s},
               {"state", to_string(health.recorder)},
               {"message", health.recorder_message},
               {"path", health.recording_path},
               {"part", health.recording_part},
               {"recording_s", health.recording_s},
               {"file_bytes", health.recorded_bytes},
               {"session_bytes", health.session_bytes},
               {"write_rate_bytes_per_s", health.write_rate_bytes_per_s},
               {"disk_free_bytes", health.disk_free_bytes},
               {"disk_free_s", health.disk_free_s},
               {"pre_trigger_s", health.pre_trigger_s},
               {"pre_trigger_bytes", health.pre_trigger_bytes},
               {"pre_trigger_cut_off", health.pre_trigger_cut_off},
               {"copy", std::move(copy)},
               {"battery_percent", health.battery_percent > 0 ? json(health.battery_percent) : json(nullptr)},
               {"on_battery", health.on_battery}});
}

std::string error_json(std::string_view message) { return dump({{"error", std::string(message)}}); }

std::optional<ChannelId> channel_in_query(std::string_view target) {
  static constexpr std::string_view kName = "?channel=";
  const std::size_t start = target.find(kName);
  if (start == std::string_view::npos) return std::nullopt;
  const std::string_view digits = target.substr(start + kName.size());
  ChannelId channel = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), channel);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  return channel;
}

}  // namespace roseau::display
