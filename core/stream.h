// Streams: every sample belongs to one, and every stream has one topic.
//
//   /camera0/image                         frames as received                       raw
//   /sonic/raw                             bytes as received                        raw
//   /sonic/wind                            decoded wind records                     derived
//   /camera0/target/branch/displacement    motion of one target                     derived
//   /truth/...                             what a simulation knows                  raw
//
// Raw streams are a session's inputs: recorded as they come and replayed in the recorded order. Derived streams are pure
// functions of the inputs: recorded for convenience, thrown away and made again on replay, and digested.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace roseau {

using StreamId = std::uint16_t;

enum class StreamRole : std::uint8_t { raw, derived, health };

/// What a stream is. `metadata` travels into the session file (channel metadata); keys in use are listed in docs/sessions.md.
struct StreamInfo {
  std::string topic;  // starts with '/', unique in a session
  std::string kind;   // name of the payload type: to_string(SampleKind)
  StreamRole role = StreamRole::raw;
  std::string device;  // the device this came from, directly or through decoding; empty for roseau's own streams
  std::map<std::string, std::string> metadata;
};

/// All streams of a running session, append-only. Thread-safe. An id is an index and stays valid for the table's life.
class StreamTable {
 public:
  /// Id of the stream with this topic; adds it when it is new. The first description of a topic stands.
  StreamId add(StreamInfo info);
  std::optional<StreamId> find(std::string_view topic) const;
  /// The reference stays valid and constant for the table's life.
  const StreamInfo& info(StreamId id) const;
  std::size_t size() const;

 private:
  mutable std::mutex mutex_;
  std::deque<StreamInfo> streams_;  // deque: references survive growth
  std::map<std::string, StreamId, std::less<>> by_topic_;
};

}  // namespace roseau
