// SessionWriter: samples -> messages -> chunks of one file. The part of the recorder that knows no thread and no queue.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/result.h"
#include "core/sample.h"
#include "core/stream.h"
#include "recorder/format/chunk_builder.h"
#include "recorder/format/io.h"
#include "recorder/format/topics.h"
#include "recorder/format/writer.h"

namespace roseau::recorder {

struct SessionDescription;
struct RecorderOptions;

/// What tells one part of a session from another.
struct PartHead {
  std::string session_id;
  std::uint32_t part = 1;
  std::vector<Sample> repeated;  // of earlier parts; their arrival times are their log times
};

/// What became of samples since last asked: how many of each stream were written or lost, and how many bytes of the queue's
/// budget they held.
struct Written {
  std::map<StreamId, std::uint64_t> samples;
  std::map<StreamId, std::uint64_t> lost;
  std::map<StreamId, std::uint64_t> lost_in_encoder;
  std::uint64_t budget_bytes = 0;
};

class SessionWriter {
 public:
  SessionWriter(mcap::Writable& out, const StreamTable& streams, const RecorderOptions& options);

  /// The file's head: who, when, configuration, site, and what earlier parts know already.
  Result<void> begin(const SessionDescription& description, const PartHead& head);

  /// Adds the sample to its chunk, and writes that chunk when it is full. Pixels are not copied: the frame is held until they
  /// are written. `budget_bytes` comes back in take_written() at that time. After an Error, abandon(): the sample is lost.
  Result<void> add(const Sample& sample, HostTime log_time, std::uint64_t budget_bytes);

  /// Writes the chunks as they are.
  Result<void> flush();
  /// Writes the chunks that were begun before the last call of this: called regularly, it bounds how long a sample waits.
  Result<void> flush_older();
  /// Counters so far, as a private record.
  Result<void> checkpoint(const mcap::Metadata& counters);
  /// Gives up what has not been written, after a failure.
  void abandon();
  /// The final counters and the summary. Flush first.
  Result<void> finish(const mcap::Metadata& counters);

  /// Samples count as written when the file has got them, not when it was asked to take them.
  Written take_written();
  std::uint64_t bytes() const { return writer_.bytes_written(); }
  /// How large the file would be if it were finished after this sample: never less than it then is.
  std::uint64_t bytes_with(const Sample& sample);

 private:
  /// Pictures and the rest go to chunks of their own: pictures do not compress, the rest does, and who wants only the rest
  /// need not read pictures.
  struct OpenChunk {
    explicit OpenChunk(mcap::Compression compression) : chunk(compression) {}
    mcap::ChunkBuilder chunk;
    std::vector<FrameLease> leases;  // of the pixels in it
    Written held;
    bool older = false;  // begun before the last flush_older
  };
  Result<std::uint16_t> channel_id_of(const Sample& sample);
  Result<std::uint16_t> schema_id_of(const StreamInfo& stored);
  std::span<const std::byte> serialize_head(const Sample& sample, bool is_coded);
  Result<void> write(OpenChunk& open);
  /// Samples in chunks that the file has taken, and where they end in it.
  struct Appended {
    std::uint64_t end = 0;
    std::map<StreamId, std::uint64_t> samples;
  };
  static void clear(OpenChunk& open);

  mcap::Writable& out_;
  mcap::Writer writer_;
  const StreamTable& streams_;
  const RecorderOptions& options_;
  OpenChunk images_{mcap::Compression::none};
  OpenChunk small_{mcap::Compression::zstd};
  Written written_;
  std::deque<Appended> appended_;
  std::map<std::string, std::uint16_t> schema_ids_;        // by the message's name
  std::vector<std::optional<std::uint16_t>> channel_ids_;  // by stream
  std::uint16_t next_channel_id_ = 1;
  std::vector<std::byte> head_;  // reused
};

}  // namespace roseau::recorder
