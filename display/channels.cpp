#include "display/channels.h"

#include "core/sample.h"
#include "display/inbox.h"
#include "schema/schemas.h"

namespace roseau::display {

namespace {

using std::chrono::seconds;

constexpr seconds kHistory{150};  // more than the page's charts show at first

Retention retention_of(SampleKind kind) {
  switch (kind) {
    case SampleKind::wind:
    case SampleKind::displacement:
    case SampleKind::wind_estimate:
      return {.on_subscribe = 1, .for_history = kHistory};
    case SampleKind::camera_calibration:
    case SampleKind::identification:
    case SampleKind::wind_calibration:
    case SampleKind::force_spectrum:
    case SampleKind::health:
    case SampleKind::station_pose:
    case SampleKind::led_board_time:
    case SampleKind::marker_positions:
    case SampleKind::modal_state:
      return {.on_subscribe = 1};
    case SampleKind::clock_state:  // one channel may speak of several devices
    case SampleKind::operator_action:
    case SampleKind::gap:
    case SampleKind::drop:
    case SampleKind::log:
      return {.on_subscribe = 32};
    case SampleKind::raw_bytes:
    case SampleKind::frame:
    case SampleKind::skip:
    case SampleKind::image_motion:
      break;
  }
  return {};
}

constexpr std::string_view kStateSchema = R"({
  "type": "object",
  "title": "roseau.DisplayState",
  "properties": {
    "time_ns": {"type": "string", "description": "newest host time seen, ns"},
    "clients": {"type": "integer"},
    "images_dropped": {"type": "integer", "description": "pictures replaced by newer ones before they were sent, all clients"},
    "messages_dropped": {"type": "integer", "description": "messages the display could not take from the pipeline"},
    "slow_clients": {"type": "integer", "description": "clients let go because they could not keep up"},
    "pictures": {"type": "array", "items": {"type": "object", "description": "size of a camera's own picture", "properties": {
      "topic": {"type": "string"}, "width_px": {"type": "integer"}, "height_px": {"type": "integer"}}}},
    "player": {"type": ["object", "null"], "properties": {
      "playing": {"type": "boolean"}, "ended": {"type": "boolean"},
      "speed": {"type": ["number", "null"], "description": "null: as fast as possible"},
      "position_ns": {"type": "string"}, "begin_ns": {"type": "string"}, "end_ns": {"type": "string"},
      "jumps": {"type": "integer", "description": "rises when what was shown before belongs to another place"}}}
  }
})";

}  // namespace

bool is_camera(const StreamInfo& info) { return info.kind == to_string(SampleKind::frame); }

ChannelSetup stream_channel(StreamId id, const StreamInfo& info) {
  ChannelSetup setup{.channel = {.id = channel_of(id), .topic = info.topic}};
  const auto kind = sample_kind_from_string(info.kind);
  if (!kind) return setup;  // a kind of a newer program: advertised without a schema, never sent
  const schema::Schema schema = schema::schema_of(*kind);
  setup.channel.schema_name = std::string(schema.name);
  setup.channel.schema = base64(schema.descriptor_set);
  setup.retention = retention_of(*kind);
  setup.conflated = is_conflated(*kind);
  return setup;
}

ChannelSetup preview_channel(StreamId id, const StreamInfo& info) {
  const schema::Schema schema = schema::compressed_image_schema();
  return {.channel = {.id = preview_channel_of(id),
                      .topic = info.topic + "/preview",
                      .schema_name = std::string(schema.name),
                      .schema = base64(schema.descriptor_set)},
          .retention = {.on_subscribe = 1},  // of a paused replay it is the only one
          .conflated = true};
}

ChannelSetup state_channel() {
  return {.channel = {.id = kStateChannel,
                      .topic = std::string(kStateTopic),
                      .encoding = "json",
                      .schema_name = "roseau.DisplayState",
                      .schema = std::string(kStateSchema),
                      .schema_encoding = "jsonschema"},
          .retention = {.on_subscribe = 1},
          .conflated = false};
}

}  // namespace roseau::display
