// Losses: what a recovery found of each topic, and what it knows to be missing.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "recorder/format/chunk_content.h"
#include "recorder/format/topics.h"
#include "recorder/tools/recover/recovery.h"

namespace roseau::recorder {

class Losses {
 public:
  /// Channels' topics, as far as they are known.
  void name(std::uint16_t channel_id, const std::string& topic) { channels_[channel_id].topic = topic; }

  void keep(const mcap::ChunkContent::MessageEntry& message);
  void lose(LostStretch stretch);
  /// The message index of the chunk that was lost last.
  void lose_indexed(std::uint16_t channel_id, std::uint64_t count);
  /// Counters that stand here in the file: of what was recorded until then.
  void count(const mcap::Metadata& metadata);
  /// The file's own, when they can be trusted.
  void set_statistics(const mcap::Statistics& statistics) { statistics_ = statistics; }

  const std::vector<LostStretch>& stretches() const { return stretches_; }
  std::vector<LostStretch>& stretches() { return stretches_; }
  /// Everything together, by topic.
  std::vector<TopicRecovery> topics() const;
  /// The counters for the end of the recovered file: what was counted last, `recorded` being what is kept. What is lost is
  /// missing between them: it was neither recorded nor dropped.
  std::optional<mcap::Metadata> final_counters() const;
  std::optional<std::uint64_t> last_message_ns() const { return last_message_ns_; }
  std::uint64_t messages() const { return messages_; }

 private:
  struct ChannelState {
    std::string topic;
    std::uint64_t messages = 0;
    std::uint64_t steps_of_one = 0;
    std::uint64_t missing = 0;
    std::uint64_t first_ns = 0;
    std::uint64_t last_ns = 0;
    std::uint32_t last_sequence = 0;
    std::size_t stretches_seen = 0;
    bool counts_up() const { return 2 * steps_of_one + 2 > messages; }
  };
  std::string topic_of(std::uint16_t channel_id) const;
  void count_step(ChannelState& channel, std::uint32_t sequence);

  std::map<std::uint16_t, ChannelState> channels_;
  std::vector<LostStretch> stretches_;
  std::size_t open_stretches_ = 0;  // so many of the last ones wait for the first message behind them
  std::optional<mcap::TopicCounters> counters_;
  mcap::TopicCounters session_counters_;  // of all parts of the session, as they stood with counters_
  std::map<std::string, std::uint64_t> lost_before_counters_;
  std::optional<mcap::Statistics> statistics_;
  std::optional<std::uint64_t> last_message_ns_;
  std::uint64_t messages_ = 0;
};

}  // namespace roseau::recorder
