// ChunkBuilder: gathers the records of one chunk. What is small is copied; what is large (pixels) is borrowed until the chunk
// has been written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "recorder/format/compression.h"
#include "recorder/format/records.h"

namespace roseau::mcap {

class ChunkBuilder {
 public:
  explicit ChunkBuilder(Compression compression = Compression::none) : compression_(compression) {}

  void add(const Schema& schema);
  void add(const Channel& channel);
  /// `message.data` is copied; `borrowed` follows it in the message and is not copied (unless the chunk is compressed): it must
  /// stay as it is until clear().
  void add(const Message& message, std::span<const std::byte> borrowed = {});

  bool empty() const { return uncompressed_bytes() == 0; }
  std::uint64_t uncompressed_bytes() const { return copied_.size() + borrowed_bytes_; }
  /// 0 when there is no message.
  std::uint64_t start_time_ns() const { return message_count_ == 0 ? 0 : start_time_ns_; }
  std::uint64_t end_time_ns() const { return message_count_ == 0 ? 0 : end_time_ns_; }
  std::uint64_t message_count() const { return message_count_; }
  Compression compression() const { return compression_; }

  const std::vector<Schema>& schemas() const { return schemas_; }
  const std::vector<Channel>& channels() const { return channels_; }
  /// By channel; a channel without messages in this chunk has no entries.
  const std::map<std::uint16_t, MessageIndex>& indexes() const { return indexes_; }

  /// The uncompressed records, in order, as pieces of memory. Valid until the next add or clear.
  void parts(std::vector<std::span<const std::byte>>& out) const;

  /// Forgets everything, keeps the memory.
  void clear();

 private:
  struct Borrowed {
    std::size_t after;  // comes after so many copied bytes
    std::span<const std::byte> bytes;
  };

  Compression compression_;
  std::vector<std::byte> copied_;
  std::vector<Borrowed> borrowed_;
  std::uint64_t borrowed_bytes_ = 0;
  std::uint64_t message_count_ = 0;
  std::uint64_t start_time_ns_ = 0;
  std::uint64_t end_time_ns_ = 0;
  std::vector<Schema> schemas_;
  std::vector<Channel> channels_;
  std::map<std::uint16_t, MessageIndex> indexes_;
};

}  // namespace roseau::mcap
