#include "recorder/tools/merge/merge_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "recorder/tools/rewrite/session_output.h"
#include "schema/conversion.h"

namespace roseau::recorder {

namespace {

constexpr std::string_view kHostKey = "host";
constexpr std::string_view kCivilClock = "utc";  // ClockState::device of a host's clock against civil time

std::string entry_of(const mcap::SessionInfo& info, std::string_view key) {
  const auto found = info.other.find(std::string(key));
  return found == info.other.end() ? "" : found->second;
}

/// Two parts of one session: the session id says so. That of a simulation is made of its texts alone, so those that differ in
/// their seed have one id, but do not say the same of themselves. Files without an id have at least the same clock, to the
/// nanosecond.
bool is_same_session(const mcap::SessionInfo& a, const mcap::SessionInfo& b) {
  constexpr std::string_view kMadeOfTexts = "00000000-";
  if (a.session_id != b.session_id) return false;
  if (!a.session_id.empty() && !a.session_id.starts_with(kMadeOfTexts)) return true;
  return !a.other.empty() && a.other == b.other && (!a.session_id.empty() || a.utc_minus_host_time == b.utc_minus_host_time);
}

/// The host's own record of its clock against civil time; nothing when it made none.
Result<std::optional<CivilOffset>> recorded_offset(mcap::IndexedReader& reader) {
  mcap::MessageQuery query{.channels = std::vector<std::uint16_t>{}};
  for (const auto& [id, channel] : reader.catalog().channels()) {
    const auto info = mcap::stream_info_from(channel, reader.catalog().schema_of(channel));
    if (info && info->kind == to_string(SampleKind::clock_state) && info->device == kCivilClock) query.channels->push_back(id);
  }
  if (query.channels->empty()) return std::optional<CivilOffset>{};
  const StreamTable no_streams;
  std::vector<std::pair<HostTime, Duration>> points;
  auto messages = reader.messages(query);
  for (auto message = messages.next(); !message || *message; message = messages.next()) {
    if (!message) continue;  // a broken chunk: said when the messages are merged
    SampleHeader known;
    known.sample_time = mcap::host_time_from((*message)->message.publish_time_ns);
    const auto sample = schema::parse(SampleKind::clock_state, (*message)->message.data, known, no_streams);
    if (!sample) return sample.error();
    const auto& clock = std::get<ClockState>(sample->payload);
    const HostTime time = sample->header.sample_time;
    if (clock.device == kCivilClock && (points.empty() || points.back().first < time)) {
      points.emplace_back(time, -from_seconds(clock.offset_s));
    }
  }
  if (points.empty()) return std::optional<CivilOffset>{};
  return std::optional(CivilOffset(std::move(points)));
}

Result<MergeInput> open_input(const std::filesystem::path& path) {
  MergeInput input{.path = path};
  auto reader = mcap::IndexedReader::open(path);
  if (!reader) return reader.error();
  input.reader = std::move(*reader);
  auto info = read_session_info(*input.reader);
  if (!info) return info.error().with_context(path.string());
  input.info = std::move(*info);
  if (input.info.utc_minus_host_time) input.civil_offset = CivilOffset(*input.info.utc_minus_host_time);
  auto recorded = recorded_offset(*input.reader);
  if (!recorded) return recorded.error().with_context(path.string());
  if (*recorded) input.civil_offset = std::move(**recorded);
  return input;
}

class Planner {
 public:
  explicit Planner(const MergeOptions& options) : options_(options) {}

  Result<MergePlan> make(const std::vector<std::filesystem::path>& files) {
    for (const auto& path : files) {
      auto input = open_input(path);
      if (!input) return input.error();
      plan_.inputs.push_back(std::move(*input));
    }
    if (auto grouped = group(); !grouped) return grouped.error();
    for (std::size_t i = 0; i < plan_.inputs.size(); ++i) add_channels(i);
    return std::move(plan_);
  }

 private:
  /// Which files belong together, and how the others come onto the first one's axis.
  Result<void> group() {
    auto& inputs = plan_.inputs;
    std::size_t groups = 0;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      const auto same =
          std::ranges::find_if(inputs.begin(), inputs.begin() + static_cast<std::ptrdiff_t>(i),
                               [&](const MergeInput& other) { return is_same_session(other.info, inputs[i].info); });
      const bool is_new = same == inputs.begin() + static_cast<std::ptrdiff_t>(i);
      inputs[i].group = is_new ? groups++ : same->group;
      inputs[i].host = is_new ? unique_host(i) : same->host;
      // A session that went on after a reboot has another clock in its later parts.
      const bool has_first_clock = inputs[i].info.utc_minus_host_time == inputs.front().info.utc_minus_host_time;
      if (inputs[i].group == 0 && has_first_clock) continue;
      if (auto moved = move(inputs[i]); !moved) return moved;
    }
    return {};
  }

  std::string unique_host(std::size_t i) {
    const MergeInput& input = plan_.inputs[i];
    std::string host = i < options_.prefixes.size() ? options_.prefixes[i] : "";
    if (host.empty()) host = entry_of(input.info, kHostKey);
    if (host.empty()) host = input.path.stem().string();
    std::ranges::replace(host, '/', '_');
    const std::string name = host;
    for (int n = 2; !hosts_.insert(host).second; ++n) host = fmt::format("{}-{}", name, n);
    return host;
  }

  Result<void> move(MergeInput& input) {
    const MergeInput& first = plan_.inputs.front();
    for (const MergeInput* one : {&first, static_cast<const MergeInput*>(&input)}) {
      if (one->civil_offset.is_known()) continue;
      return Error{ErrorCode::invalid_argument,
                   fmt::format("{}: it does not say what its times are in civil time (utc_minus_host_time_ns), so it cannot be "
                               "merged with another host's",
                               one->path.string())};
    }
    const bool both_constant = first.civil_offset.is_constant() && input.civil_offset.is_constant();
    if (both_constant && first.civil_offset.points().front().second == input.civil_offset.points().front().second) return {};
    input.is_moved = true;
    const HostTime begin = mcap::host_time_from(input.reader->index().statistics.message_start_time_ns);
    const Duration shift = recorder::moved(begin, input.civil_offset, first.civil_offset) - begin;
    input.moved_by = fmt::format("{:+.9f} s{}", to_seconds(shift),
                                 both_constant ? "" : " at its start, from then on by the clock offsets it recorded");
    return {};
  }

  void add_channels(std::size_t i) {
    MergeInput& input = plan_.inputs[i];
    const auto& catalog = input.reader->catalog();
    for (const auto& [id, channel] : catalog.channels()) {
      const mcap::Schema* schema = catalog.schema_of(channel);
      mcap::Channel merged = channel;
      merged.schema_id = schema == nullptr ? std::uint16_t{0} : add_schema(*schema);
      merged.topic = topic_for(i, channel.topic, merged);
      if (merged.topic != channel.topic) rename(i, channel.topic, merged);
      input.channel_of[id] = add_channel(std::move(merged), input.group);
    }
  }

  std::uint16_t add_schema(const mcap::Schema& schema) {
    const auto same = std::ranges::find_if(plan_.schemas, [&schema](const mcap::Schema& known) {
      return known.name == schema.name && known.encoding == schema.encoding && known.data == schema.data;
    });
    if (same != plan_.schemas.end()) return same->id;
    plan_.schemas.push_back(schema);
    plan_.schemas.back().id = static_cast<std::uint16_t>(plan_.schemas.size());
    return plan_.schemas.back().id;
  }

  /// The topic as it is, unless another host has it too, or the same host with another kind of message.
  std::string topic_for(std::size_t i, const std::string& topic, const mcap::Channel& merged) const {
    const MergeInput& input = plan_.inputs[i];
    const std::string own_prefix = i < options_.prefixes.size() ? options_.prefixes[i] : "";
    const bool collides = std::ranges::any_of(plan_.inputs, [&](const MergeInput& other) {
      return other.group != input.group && other.reader->channel_of_topic(topic) != nullptr;
    });
    // The first host's names stay, so that its configuration still fits; unless it was given a prefix.
    const bool stays = !collides || (input.group == 0 && own_prefix.empty());
    std::string name = stays ? topic : "/" + input.host + (topic.starts_with('/') ? "" : "/") + topic;
    const auto taken = [&](const std::string& candidate) {
      const auto known = taken_.find(candidate);
      return known != taken_.end() && (known->second.group != input.group || known->second.schema_id != merged.schema_id ||
                                       known->second.encoding != merged.message_encoding);
    };
    const std::string wanted = name;
    for (int n = 2; taken(name); ++n) name = fmt::format("{}-{}", wanted, n);
    return name;
  }

  void rename(std::size_t i, const std::string& topic, mcap::Channel& merged) {
    const MergeInput& input = plan_.inputs[i];
    plan_.renamed[fmt::format("{} {}", input.path.filename().string(), topic)] = merged.topic;
    // Devices of the same name on two hosts are two devices, and results name the topic they were made from.
    auto& metadata = merged.metadata;
    if (const auto device = metadata.find("roseau.device"); device != metadata.end() && !device->second.empty()) {
      device->second = input.host + "." + device->second;
    }
    if (const auto source = metadata.find("source"); source != metadata.end() && source->second.starts_with('/')) {
      source->second = "/" + input.host + source->second;
    }
  }

  std::uint16_t add_channel(mcap::Channel channel, std::size_t group) {
    if (const auto known = taken_.find(channel.topic); known != taken_.end()) return known->second.id;
    channel.id = static_cast<std::uint16_t>(plan_.channels.size() + 1);
    taken_[channel.topic] = {group, channel.schema_id, channel.message_encoding, channel.id};
    plan_.channels.push_back(std::move(channel));
    return plan_.channels.back().id;
  }

  struct Taken {
    std::size_t group;
    std::uint16_t schema_id;
    std::string encoding;
    std::uint16_t id;
  };
  const MergeOptions& options_;
  MergePlan plan_;
  std::set<std::string> hosts_;
  std::map<std::string, Taken> taken_;  // by topic in the merged file
};

}  // namespace

Result<MergePlan> plan_merge(const std::vector<std::filesystem::path>& files, const MergeOptions& options) {
  if (files.empty()) return Error{ErrorCode::invalid_argument, "nothing to merge"};
  if (options.prefixes.size() > files.size()) {
    return Error{ErrorCode::invalid_argument, fmt::format("{} prefixes for {} files: give at most one per file, in their order",
                                                          options.prefixes.size(), files.size())};
  }
  return Planner(options).make(files);
}

}  // namespace roseau::recorder
