#include "recorder/format/topics.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <utility>

#include "core/check.h"
#include "schema/schemas.h"
#include "schema/utf8.h"

namespace roseau::mcap {

namespace {

constexpr std::string_view kAsReceived = "as_received";
constexpr std::string_view kKindKey = "roseau.kind";
constexpr std::string_view kRoleKey = "roseau.role";
constexpr std::string_view kDeviceKey = "roseau.device";
constexpr std::string_view kSchemaVersionKey = "schema_version";
constexpr std::string_view kProgramVersionKey = "program_version";
constexpr std::string_view kUtcKey = "utc_minus_host_time_ns";

constexpr std::array<std::string_view, 3> kRoleNames = {"raw", "derived", "health"};  // in the order of StreamRole

constexpr std::string_view kSessionIdKey = "session_id";
constexpr std::string_view kPartKey = "part";
constexpr std::string_view kRepeatedKey = "repeated_messages";

/// Before the names of counters that are the whole session's.
constexpr std::string_view kSessionPrefix = "session_";

constexpr std::size_t kAlwaysWritten = 6;  // of those below; the others only where they are not 0
constexpr std::array<std::pair<std::string_view, std::uint64_t StreamCounters::*>, 11> kCounters = {{
    {"received", &StreamCounters::received},
    {"recorded", &StreamCounters::recorded},
    {"dropped", &StreamCounters::dropped},
    {"gaps", &StreamCounters::gaps},
    {"bad", &StreamCounters::bad},
    {"late", &StreamCounters::late},
    {"dropped_intake", &StreamCounters::dropped_intake},
    {"dropped_queue", &StreamCounters::dropped_queue},
    {"dropped_encoder", &StreamCounters::dropped_encoder},
    {"dropped_write", &StreamCounters::dropped_write},
    {"repeated", &StreamCounters::repeated},
}};

template <class T>
std::optional<T> number_from(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Takes the key out of the map.
std::optional<std::string> take(StringMap& map, std::string_view key) {
  auto node = map.extract(std::string(key));
  if (node.empty()) return std::nullopt;
  return std::move(node.mapped());
}

Error bad_metadata(const Metadata& metadata, std::string_view key) {
  return {ErrorCode::corrupt, "metadata '" + metadata.name + "': '" + std::string(key) + "' is missing or not a number"};
}

struct CounterSets {
  StreamCounters file;
  std::optional<StreamCounters> session;  // where it is said
};

void add_to_text(const StreamCounters& counters, std::string_view prefix, std::string& text) {
  for (std::size_t i = 0; i < kCounters.size(); ++i) {
    const auto& [name, member] = kCounters[i];
    if (i >= kAlwaysWritten && counters.*member == 0) continue;
    if (!text.empty()) text += ' ';
    text += std::string(prefix) + std::string(name) + "=" + std::to_string(counters.*member);
  }
}

/// "received=3 recorded=2 ..." in any order; words that a newer program added are skipped.
std::optional<CounterSets> counters_from_text(std::string_view text) {
  CounterSets sets;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(' '));
    text.remove_prefix(std::min(text.size(), word.size() + 1));
    const std::size_t equals = word.find('=');
    if (equals == std::string_view::npos) return std::nullopt;
    const auto value = number_from<std::uint64_t>(word.substr(equals + 1));
    if (!value) return std::nullopt;
    std::string_view name = word.substr(0, equals);
    const bool of_session = name.starts_with(kSessionPrefix);
    if (of_session) name.remove_prefix(kSessionPrefix.size());
    const auto* known = std::ranges::find(kCounters, name, [](const auto& entry) { return entry.first; });
    if (known == kCounters.end()) continue;
    if (of_session && !sets.session) sets.session.emplace();
    StreamCounters& counters = of_session ? *sets.session : sets.file;
    counters.*(known->second) = *value;
  }
  return sets;
}

std::string counters_text(const StreamCounters& counters) {
  std::string text;
  add_to_text(counters, "", text);
  return text;
}

}  // namespace

Metadata to_metadata(const SessionInfo& info) {
  Metadata metadata{std::string(kSessionMetadata), {}};
  for (const auto& [key, value] : info.other) metadata.metadata[schema::to_utf8(key)] = schema::to_utf8(value);
  metadata.metadata[std::string(kSchemaVersionKey)] = std::to_string(info.schema_version);
  metadata.metadata[std::string(kProgramVersionKey)] = info.program_version;
  if (info.utc_minus_host_time) metadata.metadata[std::string(kUtcKey)] = std::to_string(info.utc_minus_host_time->count());
  if (!info.session_id.empty()) {
    metadata.metadata[std::string(kSessionIdKey)] = schema::to_utf8(info.session_id);
    metadata.metadata[std::string(kPartKey)] = std::to_string(info.part);
  }
  if (info.repeated_messages > 0) metadata.metadata[std::string(kRepeatedKey)] = std::to_string(info.repeated_messages);
  return metadata;
}

Result<SessionInfo> session_info_from(const Metadata& metadata) {
  SessionInfo info;
  info.other = metadata.metadata;
  info.program_version = take(info.other, kProgramVersionKey).value_or("");
  const auto version = number_from<int>(take(info.other, kSchemaVersionKey).value_or(""));
  if (!version) return bad_metadata(metadata, kSchemaVersionKey);
  info.schema_version = *version;
  if (info.schema_version > schema::kSchemaVersion) {
    return Error{ErrorCode::unsupported, "recorded by roseau " + info.program_version + " with messages of version " +
                                             std::to_string(*version) + "; this program reads versions up to " +
                                             std::to_string(schema::kSchemaVersion) + ": use a newer roseau"};
  }
  if (const auto utc = take(info.other, kUtcKey)) {
    const auto offset_ns = number_from<std::int64_t>(*utc);
    if (!offset_ns) return bad_metadata(metadata, kUtcKey);
    info.utc_minus_host_time = Duration{*offset_ns};
  }
  info.session_id = take(info.other, kSessionIdKey).value_or("");
  constexpr std::pair<std::string_view, std::uint32_t SessionInfo::*> kNumbers[] = {
      {kPartKey, &SessionInfo::part}, {kRepeatedKey, &SessionInfo::repeated_messages}};
  for (const auto& [key, member] : kNumbers) {
    const auto text = take(info.other, key);
    if (!text) continue;
    const auto number = number_from<std::uint32_t>(*text);
    if (!number) return bad_metadata(metadata, key);
    info.*member = *number;
  }
  return info;
}

ImageStorage storage_of(const StreamInfo& stream) {
  const auto found = stream.metadata.find(std::string(kStorageKey));
  if (stream.kind != to_string(SampleKind::frame) || found == stream.metadata.end()) return ImageStorage::raw;
  const auto storage = image_storage_from_string(found->second);
  return storage ? *storage : ImageStorage::png;
}

namespace {
Schema make_schema(const schema::Schema& known, std::uint16_t id) {
  return {id, std::string(known.name), std::string(schema::kEncoding), std::string(known.descriptor_set)};
}
}  // namespace

Schema make_schema(SampleKind kind, std::uint16_t id) { return make_schema(schema::schema_of(kind), id); }

Schema make_schema(const StreamInfo& stream, std::uint16_t id) {
  const auto kind = sample_kind_from_string(stream.kind);
  ROSEAU_CHECK(kind.has_value());
  if (storage_of(stream) != ImageStorage::raw) return make_schema(schema::compressed_image_schema(), id);
  return make_schema(*kind, id);
}

Channel make_channel(const StreamInfo& stream, std::uint16_t id, std::uint16_t schema_id) {
  ROSEAU_CHECK(sample_kind_from_string(stream.kind));
  Channel channel{.id = id,
                  .schema_id = schema_id,
                  .topic = schema::to_utf8(stream.topic),
                  .message_encoding = std::string(schema::kEncoding)};
  for (const auto& [key, value] : stream.metadata) channel.metadata[schema::to_utf8(key)] = schema::to_utf8(value);
  channel.metadata[std::string(kKindKey)] = stream.kind;
  channel.metadata[std::string(kRoleKey)] = kRoleNames.at(static_cast<std::size_t>(stream.role));
  channel.metadata[std::string(kDeviceKey)] = schema::to_utf8(stream.device);
  return channel;
}

Result<StreamInfo> stream_info_from(const Channel& channel, const Schema* schema) {
  StreamInfo stream{.topic = channel.topic};
  stream.metadata = channel.metadata;
  const auto kind_name = take(stream.metadata, kKindKey);
  const std::string schema_name = schema == nullptr ? "" : schema->name;
  const auto kind = schema::kind_of_schema(schema_name);
  if (!kind || channel.message_encoding != schema::kEncoding || (kind_name && *kind_name != to_string(*kind))) {
    return Error{ErrorCode::unsupported, channel.topic + ": messages of type '" + schema_name + "' (" +
                                             channel.message_encoding + (kind_name ? ", kind '" + *kind_name + "'" : "") +
                                             ") are not known to this program: left out. A newer roseau may read them"};
  }
  stream.kind = to_string(*kind);
  stream.device = take(stream.metadata, kDeviceKey).value_or("");
  const auto role_name = take(stream.metadata, kRoleKey).value_or("raw");
  const auto* role = std::ranges::find(kRoleNames, role_name);
  if (role == kRoleNames.end()) {
    return Error{ErrorCode::unsupported, channel.topic + ": role '" + role_name + "' is not known to this program: left out"};
  }
  stream.role = static_cast<StreamRole>(role - kRoleNames.begin());
  if (schema_name == schema::compressed_image_schema().name) {
    stream.metadata.try_emplace(std::string(kStorageKey), kAsReceived);
  }
  if (!stream.topic.starts_with('/')) stream.topic.insert(0, "/");  // other programs need not begin with one
  return stream;
}

std::uint64_t log_time_from(HostTime time) { return static_cast<std::uint64_t>(std::max<std::int64_t>(0, to_ns(time))); }

HostTime host_time_from(std::uint64_t log_time_ns) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::int64_t>::max();
  return host_time_from_ns(static_cast<std::int64_t>(std::min(log_time_ns, kMost)));
}

Metadata to_metadata(const TopicCounters& counters) {
  Metadata metadata{std::string(kCountersMetadata), {}};
  for (const auto& [topic, values] : counters) metadata.metadata[schema::to_utf8(topic)] = counters_text(values);
  return metadata;
}

Metadata to_metadata(const TopicCounters& file, const TopicCounters& session) {
  Metadata metadata = to_metadata(file);
  for (const auto& [topic, values] : session) {
    std::string& text = metadata.metadata[schema::to_utf8(topic)];
    if (text.empty()) text = counters_text({});  // nothing of this topic in this file
    add_to_text(values, kSessionPrefix, text);
  }
  return metadata;
}

Result<TopicCounters> counters_from(const Metadata& metadata) {
  TopicCounters counters;
  for (const auto& [topic, text] : metadata.metadata) {
    const auto sets = counters_from_text(text);
    if (!sets) return bad_metadata(metadata, topic);
    counters[topic] = sets->file;
  }
  return counters;
}

Result<TopicCounters> session_counters_from(const Metadata& metadata) {
  TopicCounters counters;
  for (const auto& [topic, text] : metadata.metadata) {
    const auto sets = counters_from_text(text);
    if (!sets) return bad_metadata(metadata, topic);
    counters[topic] = sets->session.value_or(sets->file);
  }
  return counters;
}

}  // namespace roseau::mcap
