// Topics: how roseau's streams are described in a session file, and what its metadata records are called.
//
// A session is any MCAP file; these are the conventions by which roseau writes one and recognises what it may read:
//
//   metadata "roseau"            at the head: who recorded this, and what the times mean (SessionInfo)
//   attachments                  at the head: "config.toml", "site.toml": the texts in use
//   channel metadata             "roseau.kind", "roseau.role", "roseau.device", and the stream's own keys as they are
//   private record 0x80          about once a second: the counters so far, so that a cut file still says what it lacks
//   metadata "roseau.counters"   at the end: the final counters
//
// log_time is the arrival time, made strictly increasing by the sequencer: the order in which replay feeds the samples.
// publish_time is the sample time.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/result.h"
#include "core/sample.h"
#include "core/stream.h"
#include "core/time.h"
#include "recorder/format/records.h"

namespace roseau::mcap {

inline constexpr std::string_view kSessionMetadata = "roseau";
inline constexpr std::string_view kCountersMetadata = "roseau.counters";
inline constexpr Opcode kCheckpointOpcode = Opcode::first_private;
inline constexpr std::string_view kConfigAttachment = "config.toml";
inline constexpr std::string_view kSiteAttachment = "site.toml";
inline constexpr std::string_view kTomlMediaType = "application/toml";

/// The metadata record "roseau".
struct SessionInfo {
  int schema_version = 0;       // schema::kSchemaVersion of the writer
  std::string program_version;  // "0.1.0 (1a2b3c4)"
  /// Civil time (UTC, since 1970) minus host monotonic time: add it to any time in the file. Nothing when it is not known, as
  /// in imported data without dates.
  std::optional<Duration> utc_minus_host_time;
  StringMap other;  // everything else: site name, operator, host name...

  /// A session may be split into several files, its parts; each reads alone. Parts of one session have the same id.
  std::string session_id;  // empty: written before there were parts, or by another program
  std::uint32_t part = 1;  // from 1
  /// So many messages at the front of the file repeat samples of earlier parts (calibrations, targets), restated as of the
  /// part's beginning. Whoever joins parts leaves them out. They are counted as `repeated` too.
  std::uint32_t repeated_messages = 0;
};
Metadata to_metadata(const SessionInfo& info);

/// Errors: corrupt; unsupported when a newer roseau wrote a schema version that this one would misread.
Result<SessionInfo> session_info_from(const Metadata& metadata);

/// How a stream's frames are stored: channel metadata "storage". Absent: raw. Channels of other programs that hold coded
/// pictures of some kind say "as_received", which counts as png: pictures keep the form they have, others become PNG.
inline constexpr std::string_view kStorageKey = "storage";
ImageStorage storage_of(const StreamInfo& stream);

/// The schema and channel of a stream; of frames, that of the storage its metadata say. The kind must be one that schema/ knows
/// (a bug otherwise).
Schema make_schema(SampleKind kind, std::uint16_t id);
Schema make_schema(const StreamInfo& stream, std::uint16_t id);
Channel make_channel(const StreamInfo& stream, std::uint16_t id, std::uint16_t schema_id);

/// The stream that a channel holds; `schema` null for a schemaless channel. Channels of other programs count as raw, their kind
/// being that of their schema. Error unsupported, in words for the user, when this program cannot read the channel: replay then
/// leaves it out and says so.
Result<StreamInfo> stream_info_from(const Channel& channel, const Schema* schema);

/// Host times before zero (imported data may have some) become zero in the file's own time fields; the messages keep them.
std::uint64_t log_time_from(HostTime time);
HostTime host_time_from(std::uint64_t log_time_ns);

/// Counters as a metadata record, by topic, and back. Used for checkpoints and for the end of a file.
using TopicCounters = std::map<std::string, StreamCounters>;
Metadata to_metadata(const TopicCounters& counters);
Result<TopicCounters> counters_from(const Metadata& metadata);

/// In a part of a session there are two sets: of this file (their sums over all parts are the session's), and of the session
/// from its beginning to the end of this file. One record holds both; older programs read the first.
Metadata to_metadata(const TopicCounters& file, const TopicCounters& session);
/// The session's; the file's own where nothing else is said.
Result<TopicCounters> session_counters_from(const Metadata& metadata);

}  // namespace roseau::mcap
