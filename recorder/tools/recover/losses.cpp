#include "recorder/tools/recover/losses.h"

#include <algorithm>
#include <utility>

namespace roseau::recorder {

namespace {

constexpr std::uint32_t kMostJump = std::uint32_t{1} << 31U;  // more is a step backwards

std::uint64_t value_of(const std::map<std::string, std::uint64_t>& counts, const std::string& topic) {
  const auto found = counts.find(topic);
  return found == counts.end() ? 0 : found->second;
}

}  // namespace

std::string Losses::topic_of(std::uint16_t channel_id) const {
  const auto found = channels_.find(channel_id);
  const bool known = found != channels_.end() && !found->second.topic.empty();
  return known ? found->second.topic : "channel " + std::to_string(channel_id);
}

void Losses::count_step(ChannelState& channel, std::uint32_t sequence) {
  const std::uint32_t step = sequence - channel.last_sequence;
  if (step == 1) ++channel.steps_of_one;
  if (step <= 1 || step >= kMostJump) return;
  channel.missing += step - 1;
  // Stretches lost since this channel's last message.
  if (channel.stretches_seen < stretches_.size()) stretches_.back().sequence_jump[channel.topic] += step - 1;
}

void Losses::keep(const mcap::ChunkContent::MessageEntry& message) {
  ChannelState& channel = channels_[message.channel_id];
  if (channel.messages == 0) {
    channel.first_ns = message.log_time_ns;
    channel.last_ns = message.log_time_ns;
  } else {
    count_step(channel, message.sequence);
  }
  channel.first_ns = std::min(channel.first_ns, message.log_time_ns);
  channel.last_ns = std::max(channel.last_ns, message.log_time_ns);
  channel.last_sequence = message.sequence;
  channel.stretches_seen = stretches_.size();
  ++channel.messages;
  ++messages_;
  for (; open_stretches_ > 0; --open_stretches_) {
    LostStretch& stretch = stretches_[stretches_.size() - open_stretches_];
    if (!stretch.to_ns) stretch.to_ns = message.log_time_ns;
  }
  last_message_ns_ = std::max(last_message_ns_.value_or(0), message.log_time_ns);
}

void Losses::lose(LostStretch stretch) {
  if (!stretch.from_ns) stretch.from_ns = last_message_ns_;
  stretches_.push_back(std::move(stretch));
  ++open_stretches_;
}

void Losses::lose_indexed(std::uint16_t channel_id, std::uint64_t count) {
  stretches_.back().messages[topic_of(channel_id)] += count;
}

void Losses::count(const mcap::Metadata& metadata) {
  auto read = mcap::counters_from(metadata);
  if (!read) return;
  mcap::TopicCounters counters = std::move(*read);
  if (auto session = mcap::session_counters_from(metadata)) session_counters_ = std::move(*session);
  std::map<std::string, std::uint64_t> found;
  for (const auto& [id, channel] : channels_) found[channel.topic] += channel.messages;
  lost_before_counters_.clear();
  for (const auto& [topic, counted] : counters) {
    const std::uint64_t kept = value_of(found, topic);
    if (counted.recorded > kept) lost_before_counters_[topic] = counted.recorded - kept;
  }
  counters_ = std::move(counters);
}

std::vector<TopicRecovery> Losses::topics() const {
  std::map<std::string, TopicRecovery> topics;
  for (const auto& [id, channel] : channels_) {
    TopicRecovery& topic = topics[channel.topic];
    topic.topic = channel.topic;
    if (channel.messages > 0) {
      topic.first_ns = topic.messages == 0 ? channel.first_ns : std::min(topic.first_ns, channel.first_ns);
      topic.last_ns = std::max(topic.last_ns, channel.last_ns);
    }
    topic.messages += channel.messages;
    if (channel.counts_up()) topic.missing_in_sequence += channel.missing;
    if (!statistics_) continue;
    const auto counted = statistics_->channel_message_counts.find(id);
    if (counted != statistics_->channel_message_counts.end() && counted->second > channel.messages) {
      topic.lost = counted->second - channel.messages;
    }
  }
  std::map<std::string, std::uint64_t> indexed;
  for (const LostStretch& stretch : stretches_) {
    for (const auto& [topic, count] : stretch.messages) indexed[topic] += count;
  }
  for (const auto* lost :
       std::initializer_list<const std::map<std::string, std::uint64_t>*>{&lost_before_counters_, &indexed}) {
    for (const auto& [name, count] : *lost) {
      TopicRecovery& topic = topics[name];
      topic.topic = name;
      topic.lost = std::max(topic.lost, count);
    }
  }
  std::vector<TopicRecovery> all;
  for (auto& [name, topic] : topics) {
    if (counters_ && counters_->contains(name)) topic.counters = counters_->at(name);
    all.push_back(std::move(topic));
  }
  return all;
}

std::optional<mcap::Metadata> Losses::final_counters() const {
  if (!counters_) return std::nullopt;
  mcap::TopicCounters counters = *counters_;
  for (const TopicRecovery& topic : topics()) {
    StreamCounters& counted = counters[topic.topic];
    counted.recorded = topic.messages;
    counted.received = std::max(counted.received, counted.recorded + counted.dropped);
  }
  return mcap::to_metadata(counters, session_counters_);
}

}  // namespace roseau::recorder
