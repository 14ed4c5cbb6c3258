// SessionOutput: a session file made from messages of others (cut, merge). Owns the file: unless finish() succeeded, nothing is
// left of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/stream.h"
#include "core/time.h"
#include "recorder/format/chunk_builder.h"
#include "recorder/format/file_io.h"
#include "recorder/format/indexed_reader.h"
#include "recorder/format/topics.h"
#include "recorder/format/writer.h"

namespace roseau::recorder {

/// Called now and then with the share done. False: stop, the user wants to.
using ToolProgress = std::function<bool(double share)>;

/// What the messages of a file say about themselves: for the counters of a file that holds only some of them. `received` is
/// what is recorded and what the drops that are recorded with it speak of.
class MessageCounter {
 public:
  void add_channel(const mcap::Channel& channel, const mcap::Schema* schema);
  void add(const mcap::Message& message);
  void add_repeated(std::uint16_t channel_id) { ++streams_[channel_id].counters.repeated; }
  mcap::TopicCounters counters() const;

 private:
  struct Stream {
    std::string topic;
    std::optional<SampleKind> kind;  // nothing: of another program
    StreamCounters counters;
  };
  std::map<std::uint16_t, Stream> streams_;
  std::map<std::string, std::uint64_t> dropped_;  // by the topic concerned
  std::map<std::string, std::uint64_t> gaps_;
  StreamTable no_streams_;
};

class SessionOutput {
 public:
  /// Makes the file; an existing one is an error.
  static Result<std::unique_ptr<SessionOutput>> create(const std::filesystem::path& path, const mcap::Header& header);
  ~SessionOutput();
  SessionOutput(const SessionOutput&) = delete;
  SessionOutput& operator=(const SessionOutput&) = delete;

  Result<void> write(const mcap::Schema& schema) { return writer_.write(schema); }
  Result<void> write(const mcap::Attachment& attachment) { return writer_.write(attachment); }
  Result<void> write(const mcap::Metadata& metadata) { return writer_.write(metadata); }
  /// `schema` is the channel's, null for none.
  Result<void> write(const mcap::Channel& channel, const mcap::Schema* schema);

  /// Copies the message into a chunk with its like: pictures apart, as in every session.
  Result<void> add(const mcap::Message& message);
  /// A chunk as another file has it, not compressed anew; `records` are what it holds. Tell its messages to count().
  Result<void> copy_chunk(const mcap::Chunk& chunk, std::span<const std::byte> records);
  /// A message that went out with copy_chunk().
  void count(const mcap::Message& message) { counter_.add(message); }
  /// One message of this channel, added beside, repeats what an earlier part of the session holds.
  void count_repeated(std::uint16_t channel_id) { counter_.add_repeated(channel_id); }

  /// The counters, the summary, and on disk it is.
  Result<void> finish();

  std::uint64_t bytes() const { return writer_.bytes_written(); }
  const mcap::Statistics& statistics() const { return writer_.statistics(); }

 private:
  SessionOutput(std::unique_ptr<mcap::FileWritable> file, std::filesystem::path path)
      : path_(std::move(path)), file_(std::move(file)), writer_(*file_) {}
  Result<void> flush(mcap::ChunkBuilder& chunk);

  std::filesystem::path path_;
  std::unique_ptr<mcap::FileWritable> file_;
  mcap::Writer writer_;
  mcap::ChunkBuilder pictures_{mcap::Compression::none};
  mcap::ChunkBuilder small_{mcap::Compression::zstd};
  std::map<std::uint16_t, bool> is_picture_;  // by channel
  MessageCounter counter_;
  bool finished_ = false;
};

/// What a session says of itself, empty where it says nothing (files of other programs). Error: of a newer roseau.
Result<mcap::SessionInfo> read_session_info(mcap::IndexedReader& reader);

}  // namespace roseau::recorder
