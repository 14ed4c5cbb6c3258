// StreamCheck: the messages of every channel, one after another: order, numbers, payloads.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/sample.h"
#include "core/stream.h"
#include "recorder/format/catalog.h"
#include "recorder/format/records.h"
#include "recorder/format/topics.h"
#include "recorder/tools/inspect/problems.h"
#include "recorder/tools/inspect/verification.h"
#include "schema/payload_check.h"

namespace roseau::recorder {

class StreamCheck {
 public:
  explicit StreamCheck(Problems& problems) : problems_(problems) {}

  void see(const mcap::Channel& channel, const mcap::Schema* schema);
  void see(const mcap::Message& message);
  /// The recorder's final counters.
  void see(const mcap::TopicCounters& counters);

  std::uint64_t messages() const { return messages_; }
  std::uint64_t messages_of(std::uint16_t channel_id) const;
  std::map<std::uint16_t, std::uint64_t> counts() const;
  /// Log times of the earliest and the latest message; 0 when there is none.
  std::uint64_t start_time_ns() const { return start_time_ns_; }
  std::uint64_t end_time_ns() const { return end_time_ns_; }

  std::vector<StreamVerification> finish();

 private:
  struct Stream {
    StreamVerification report;
    std::optional<SampleKind> kind;
    std::optional<schema::PayloadChecker> checker;
    bool is_json = false;
    bool is_raw = false;
    std::uint64_t bad_payloads = 0;
    std::uint64_t steps_of_one = 0;
    std::uint64_t out_of_order = 0;
    std::uint32_t last_sequence = 0;
    std::uint64_t last_log_time_ns = 0;
  };
  void choose_check(Stream& stream, const mcap::Channel& channel, const mcap::Schema* schema);
  void check_order(Stream& stream, const mcap::Message& message);
  void check_payload(Stream& stream, const mcap::Message& message);
  Result<void> parse(const Stream& stream, const mcap::Message& message) const;

  Problems& problems_;
  StreamTable table_;
  std::map<std::uint16_t, Stream> streams_;
  std::uint64_t messages_ = 0;
  std::uint64_t start_time_ns_ = 0;
  std::uint64_t end_time_ns_ = 0;
};

}  // namespace roseau::recorder
