#include "recorder/format/chunk_builder.h"

#include <algorithm>

#include "recorder/format/codec.h"

namespace roseau::mcap {

void ChunkBuilder::add(const Schema& schema) {
  encode(schema, copied_);
  schemas_.push_back(schema);
}

void ChunkBuilder::add(const Channel& channel) {
  encode(channel, copied_);
  channels_.push_back(channel);
}

void ChunkBuilder::add(const Message& message, std::span<const std::byte> borrowed) {
  MessageIndex& index = indexes_[message.channel_id];
  index.channel_id = message.channel_id;
  index.entries.emplace_back(message.log_time_ns, uncompressed_bytes());
  start_time_ns_ = message_count_ == 0 ? message.log_time_ns : std::min(start_time_ns_, message.log_time_ns);
  end_time_ns_ = message_count_ == 0 ? message.log_time_ns : std::max(end_time_ns_, message.log_time_ns);
  ++message_count_;

  encode_message_head(message, message.data.size() + borrowed.size(), copied_);
  copied_.insert(copied_.end(), message.data.begin(), message.data.end());
  if (borrowed.empty()) return;
  if (compression_ != Compression::none) {
    copied_.insert(copied_.end(), borrowed.begin(), borrowed.end());
    return;
  }
  borrowed_.push_back({copied_.size(), borrowed});
  borrowed_bytes_ += borrowed.size();
}

void ChunkBuilder::parts(std::vector<std::span<const std::byte>>& out) const {
  const std::span<const std::byte> copied(copied_);
  std::size_t at = 0;
  for (const Borrowed& borrowed : borrowed_) {
    out.push_back(copied.subspan(at, borrowed.after - at));
    out.push_back(borrowed.bytes);
    at = borrowed.after;
  }
  if (at < copied.size()) out.push_back(copied.subspan(at));
}

void ChunkBuilder::clear() {
  copied_.clear();
  borrowed_.clear();
  borrowed_bytes_ = 0;
  message_count_ = 0;
  schemas_.clear();
  channels_.clear();
  for (auto& [channel_id, index] : indexes_) index.entries.clear();
}

}  // namespace roseau::mcap
