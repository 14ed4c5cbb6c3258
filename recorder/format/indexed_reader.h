// IndexedReader: messages of a file in order of log time, by time and by channel.
//
// Works with any MCAP file: chunked or not, with overlapping chunks, with or without a summary, cut off at any byte. Use it
// from one thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "recorder/format/chunk_records.h"
#include "recorder/format/file_index.h"
#include "recorder/format/io.h"
#include "recorder/format/records.h"

namespace roseau::mcap {

class MessageCursor;

struct MessageQuery {
  /// Only these channels; every channel when not set.
  std::optional<std::vector<std::uint16_t>> channels;
  std::uint64_t start_time_ns = 0;                                        // first log time wanted
  std::uint64_t end_time_ns = std::numeric_limits<std::uint64_t>::max();  // last log time wanted
};

class IndexedReader {
 public:
  static Result<std::unique_ptr<IndexedReader>> open(const std::filesystem::path& path, ReaderOptions options = {});
  static Result<std::unique_ptr<IndexedReader>> open(std::unique_ptr<Readable> in, ReaderOptions options = {});

  /// What the file holds and whether it is whole: header, channels, schemas, statistics, damage.
  const FileIndex& index() const { return index_; }
  const Catalog& catalog() const { return index_.catalog; }
  const Channel* channel_of_topic(std::string_view topic) const;

  /// Messages in order of (log time, place in the file). The reader must outlive the cursor; several cursors may be in use.
  MessageCursor messages(MessageQuery query = {});

  /// An attachment; its data is a view of `buffer`. Checks the CRC.
  Result<Attachment> read(const AttachmentIndex& index, std::vector<std::byte>& buffer);
  Result<Metadata> read(const MetadataIndex& index);
  /// The first metadata record with this name; nothing when there is none.
  Result<std::optional<Metadata>> find_metadata(std::string_view name);
  /// A private record in the layout of Metadata (roseau's checkpoints).
  Result<Metadata> read(const PrivateRecord& record);

 private:
  friend class MessageCursor;
  IndexedReader(std::unique_ptr<Readable> in, ReaderOptions options) : in_(std::move(in)), options_(options) {}
  Result<std::vector<std::byte>> read_content(std::uint64_t offset, std::uint64_t length, Opcode expected);

  std::unique_ptr<Readable> in_;
  ReaderOptions options_;
  FileIndex index_;
};

struct ReadMessage {
  const Channel* channel = nullptr;  // valid for the reader's life
  Message message;                   // its data is valid until the cursor's next call
};

class MessageCursor {
 public:
  MessageCursor(MessageCursor&&) noexcept;
  MessageCursor& operator=(MessageCursor&&) noexcept;
  ~MessageCursor();

  /// The next message; nothing at the end. An Error says which part of the file cannot be read (a chunk whose CRC does not
  /// match); calling again goes on without that part.
  Result<std::optional<ReadMessage>> next();

 private:
  friend class IndexedReader;
  struct State;
  explicit MessageCursor(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace roseau::mcap
