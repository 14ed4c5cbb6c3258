#include "recorder/format/codec.h"

#include <bit>
#include <cstdio>
#include <cstring>
#include <type_traits>

#include "recorder/format/crc32.h"

namespace roseau::mcap {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

namespace {

// ---------------------------------------------------------------------------------------------------------------------
// Writing

class Encoder {
 public:
  explicit Encoder(std::vector<std::byte>& out) : out_(out) {}

  template <class T>
    requires std::is_integral_v<T>
  void number(T value) {
    raw(&value, sizeof value);
  }
  void bytes(std::span<const std::byte> value) { raw(value.data(), value.size()); }
  void text(std::string_view value) {
    number(static_cast<std::uint32_t>(value.size()));
    raw(value.data(), value.size());
  }
  void strings(const StringMap& map) {
    const std::size_t at = begin_array();
    for (const auto& [key, value] : map) {
      text(key);
      text(value);
    }
    end_array(at);
  }
  void numbers(const std::map<std::uint16_t, std::uint64_t>& map) {
    const std::size_t at = begin_array();
    for (const auto& [key, value] : map) {
      number(key);
      number(value);
    }
    end_array(at);
  }
  /// Arrays and maps are preceded by their length in bytes, not in elements.
  std::size_t begin_array() {
    number(std::uint32_t{0});
    return out_.size();
  }
  void end_array(std::size_t begin) {
    const auto size = static_cast<std::uint32_t>(out_.size() - begin);
    std::memcpy(out_.data() + begin - sizeof size, &size, sizeof size);
  }
  void raw(const void* data, std::size_t size) {
    const auto* begin = static_cast<const std::byte*>(data);
    out_.insert(out_.end(), begin, begin + size);
  }

 private:
  std::vector<std::byte>& out_;
};

/// One record: head, content by `write`, length patched in afterwards.
template <class Write>
void encode_record(Opcode opcode, std::vector<std::byte>& out, Write write) {
  Encoder encoder(out);
  encoder.number(static_cast<std::uint8_t>(opcode));
  encoder.number(std::uint64_t{0});
  const std::size_t begin = out.size();
  write(encoder);
  const std::uint64_t size = out.size() - begin;
  std::memcpy(out.data() + begin - sizeof size, &size, sizeof size);
}

void write_metadata(Encoder& to, const Metadata& record) {
  to.text(record.name);
  to.strings(record.metadata);
}

// ---------------------------------------------------------------------------------------------------------------------
// Reading

class Decoder {
 public:
  explicit Decoder(std::span<const std::byte> content) : rest_(content) {}

  bool failed() const { return failed_; }
  bool empty() const { return rest_.empty(); }

  template <class T>
  void number(T& value) {
    const auto bytes = take(sizeof(T));
    if (bytes.size() == sizeof(T)) std::memcpy(&value, bytes.data(), sizeof(T));
  }
  template <class T>
  T number() {
    T value{};
    number(value);
    return value;
  }
  void text(std::string& value) {
    const auto bytes = take(number<std::uint32_t>());
    value.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  void strings(StringMap& map) {
    for_each_in_array([&map](Decoder& from) {
      std::string key;
      from.text(key);
      from.text(map[key]);
    });
  }
  void numbers(std::map<std::uint16_t, std::uint64_t>& map) {
    for_each_in_array([&map](Decoder& from) {
      const auto key = from.number<std::uint16_t>();
      from.number(map[key]);
    });
  }
  template <class Read>
  void for_each_in_array(Read read) {
    Decoder array(take(number<std::uint32_t>()));
    while (!array.empty() && !array.failed()) read(array);
    failed_ = failed_ || array.failed();
  }
  std::span<const std::byte> take(std::uint64_t size) {
    if (size > rest_.size()) {
      failed_ = true;
      rest_ = {};
      return {};
    }
    const auto taken = rest_.first(size);
    rest_ = rest_.subspan(size);
    return taken;
  }
  std::span<const std::byte> rest() { return take(rest_.size()); }

 private:
  std::span<const std::byte> rest_;
  bool failed_ = false;
};

void read(Decoder& from, Header& record) {
  from.text(record.profile);
  from.text(record.library);
}

void read(Decoder& from, Footer& record) {
  from.number(record.summary_start);
  from.number(record.summary_offset_start);
  from.number(record.summary_crc);
}

void read(Decoder& from, Schema& record) {
  from.number(record.id);
  from.text(record.name);
  from.text(record.encoding);
  from.text(record.data);
}

void read(Decoder& from, Channel& record) {
  from.number(record.id);
  from.number(record.schema_id);
  from.text(record.topic);
  from.text(record.message_encoding);
  from.strings(record.metadata);
}

void read(Decoder& from, Message& record) {
  from.number(record.channel_id);
  from.number(record.sequence);
  from.number(record.log_time_ns);
  from.number(record.publish_time_ns);
  record.data = from.rest();
}

void read(Decoder& from, Chunk& record) {
  from.number(record.start_time_ns);
  from.number(record.end_time_ns);
  from.number(record.uncompressed_size);
  from.number(record.uncompressed_crc);
  from.text(record.compression);
  record.records = from.take(from.number<std::uint64_t>());
}

void read(Decoder& from, MessageIndex& record) {
  from.number(record.channel_id);
  from.for_each_in_array([&record](Decoder& array) {
    const auto log_time_ns = array.number<std::uint64_t>();
    record.entries.emplace_back(log_time_ns, array.number<std::uint64_t>());
  });
}

void read(Decoder& from, ChunkIndex& record) {
  from.number(record.start_time_ns);
  from.number(record.end_time_ns);
  from.number(record.chunk_offset);
  from.number(record.chunk_length);
  from.numbers(record.message_index_offsets);
  from.number(record.message_index_length);
  from.text(record.compression);
  from.number(record.compressed_size);
  from.number(record.uncompressed_size);
}

void read(Decoder& from, Attachment& record) {
  from.number(record.log_time_ns);
  from.number(record.create_time_ns);
  from.text(record.name);
  from.text(record.media_type);
  record.data = from.take(from.number<std::uint64_t>());
  from.number(record.crc);
}

void read(Decoder& from, AttachmentIndex& record) {
  from.number(record.offset);
  from.number(record.length);
  from.number(record.log_time_ns);
  from.number(record.create_time_ns);
  from.number(record.data_size);
  from.text(record.name);
  from.text(record.media_type);
}

void read(Decoder& from, Statistics& record) {
  from.number(record.message_count);
  from.number(record.schema_count);
  from.number(record.channel_count);
  from.number(record.attachment_count);
  from.number(record.metadata_count);
  from.number(record.chunk_count);
  from.number(record.message_start_time_ns);
  from.number(record.message_end_time_ns);
  from.numbers(record.channel_message_counts);
}

void read(Decoder& from, Metadata& record) {
  from.text(record.name);
  from.strings(record.metadata);
}

void read(Decoder& from, MetadataIndex& record) {
  from.number(record.offset);
  from.number(record.length);
  from.text(record.name);
}

void read(Decoder& from, SummaryOffset& record) {
  record.group = static_cast<Opcode>(from.number<std::uint8_t>());
  from.number(record.group_start);
  from.number(record.group_length);
}

void read(Decoder& from, DataEnd& record) { from.number(record.data_section_crc); }

template <class T>
Result<Record> decode_as(std::uint8_t opcode, std::span<const std::byte> content) {
  Decoder decoder(content);
  T record;
  read(decoder, record);
  if (decoder.failed()) {
    return Error{ErrorCode::corrupt, "the " + name_of(opcode) + " record ends in the middle of a field"};
  }
  return Record(std::in_place_type<T>, std::move(record));
}

}  // namespace

void encode(const Header& record, std::vector<std::byte>& out) {
  encode_record(Opcode::header, out, [&](Encoder& to) {
    to.text(record.profile);
    to.text(record.library);
  });
}

void encode(const Footer& record, std::vector<std::byte>& out) {
  encode_record(Opcode::footer, out, [&](Encoder& to) {
    to.number(record.summary_start);
    to.number(record.summary_offset_start);
    to.number(record.summary_crc);
  });
}

void encode(const Schema& record, std::vector<std::byte>& out) {
  encode_record(Opcode::schema, out, [&](Encoder& to) {
    to.number(record.id);
    to.text(record.name);
    to.text(record.encoding);
    to.text(record.data);
  });
}

void encode(const Channel& record, std::vector<std::byte>& out) {
  encode_record(Opcode::channel, out, [&](Encoder& to) {
    to.number(record.id);
    to.number(record.schema_id);
    to.text(record.topic);
    to.text(record.message_encoding);
    to.strings(record.metadata);
  });
}

void encode_message_head(const Message& record, std::uint64_t data_bytes, std::vector<std::byte>& out) {
  Encoder to(out);
  to.number(static_cast<std::uint8_t>(Opcode::message));
  to.number(std::uint64_t{kMessageHeadBytes - kRecordHeadBytes} + data_bytes);
  to.number(record.channel_id);
  to.number(record.sequence);
  to.number(record.log_time_ns);
  to.number(record.publish_time_ns);
}

void encode(const Message& record, std::vector<std::byte>& out) {
  encode_message_head(record, record.data.size(), out);
  out.insert(out.end(), record.data.begin(), record.data.end());
}

void encode_chunk_head(const Chunk& record, std::uint64_t stored_bytes, std::vector<std::byte>& out) {
  Encoder to(out);
  to.number(static_cast<std::uint8_t>(Opcode::chunk));
  to.number(std::uint64_t{8 + 8 + 8 + 4 + 4 + 8} + record.compression.size() + stored_bytes);
  to.number(record.start_time_ns);
  to.number(record.end_time_ns);
  to.number(record.uncompressed_size);
  to.number(record.uncompressed_crc);
  to.text(record.compression);
  to.number(stored_bytes);
}

void encode(const MessageIndex& record, std::vector<std::byte>& out) {
  encode_record(Opcode::message_index, out, [&](Encoder& to) {
    to.number(record.channel_id);
    const std::size_t at = to.begin_array();
    for (const auto& [log_time_ns, offset] : record.entries) {
      to.number(log_time_ns);
      to.number(offset);
    }
    to.end_array(at);
  });
}

void encode(const ChunkIndex& record, std::vector<std::byte>& out) {
  encode_record(Opcode::chunk_index, out, [&](Encoder& to) {
    to.number(record.start_time_ns);
    to.number(record.end_time_ns);
    to.number(record.chunk_offset);
    to.number(record.chunk_length);
    to.numbers(record.message_index_offsets);
    to.number(record.message_index_length);
    to.text(record.compression);
    to.number(record.compressed_size);
    to.number(record.uncompressed_size);
  });
}

void encode(const Attachment& record, std::vector<std::byte>& out) {
  encode_record(Opcode::attachment, out, [&](Encoder& to) {
    const std::size_t begin = out.size();
    to.number(record.log_time_ns);
    to.number(record.create_time_ns);
    to.text(record.name);
    to.text(record.media_type);
    to.number(std::uint64_t{record.data.size()});
    to.bytes(record.data);
    to.number(crc32(0, std::span(out).subspan(begin)));
  });
}

void encode(const AttachmentIndex& record, std::vector<std::byte>& out) {
  encode_record(Opcode::attachment_index, out, [&](Encoder& to) {
    to.number(record.offset);
    to.number(record.length);
    to.number(record.log_time_ns);
    to.number(record.create_time_ns);
    to.number(record.data_size);
    to.text(record.name);
    to.text(record.media_type);
  });
}

void encode(const Statistics& record, std::vector<std::byte>& out) {
  encode_record(Opcode::statistics, out, [&](Encoder& to) {
    to.number(record.message_count);
    to.number(record.schema_count);
    to.number(record.channel_count);
    to.number(record.attachment_count);
    to.number(record.metadata_count);
    to.number(record.chunk_count);
    to.number(record.message_start_time_ns);
    to.number(record.message_end_time_ns);
    to.numbers(record.channel_message_counts);
  });
}

void encode(const Metadata& record, std::vector<std::byte>& out) {
  encode_record(Opcode::metadata, out, [&](Encoder& to) { write_metadata(to, record); });
}

void encode_private(Opcode opcode, const Metadata& record, std::vector<std::byte>& out) {
  encode_record(opcode, out, [&](Encoder& to) { write_metadata(to, record); });
}

void encode(const MetadataIndex& record, std::vector<std::byte>& out) {
  encode_record(Opcode::metadata_index, out, [&](Encoder& to) {
    to.number(record.offset);
    to.number(record.length);
    to.text(record.name);
  });
}

void encode(const SummaryOffset& record, std::vector<std::byte>& out) {
  encode_record(Opcode::summary_offset, out, [&](Encoder& to) {
    to.number(static_cast<std::uint8_t>(record.group));
    to.number(record.group_start);
    to.number(record.group_length);
  });
}

void encode(const DataEnd& record, std::vector<std::byte>& out) {
  encode_record(Opcode::data_end, out, [&](Encoder& to) { to.number(record.data_section_crc); });
}

void encode(const OtherRecord& record, std::vector<std::byte>& out) {
  encode_record(static_cast<Opcode>(record.opcode), out, [&](Encoder& to) { to.bytes(record.content); });
}

std::vector<std::byte> footer_prefix(const Footer& record) {
  std::vector<std::byte> bytes;
  encode(record, bytes);
  bytes.resize(bytes.size() - sizeof record.summary_crc);
  return bytes;
}

RecordHead decode_head(std::span<const std::byte> bytes) {
  Decoder decoder(bytes);
  RecordHead head;
  decoder.number(head.opcode);
  decoder.number(head.content_bytes);
  ROSEAU_CHECK(!decoder.failed());
  return head;
}

Result<Metadata> decode_metadata(std::span<const std::byte> content) {
  auto record = decode_as<Metadata>(static_cast<std::uint8_t>(Opcode::metadata), content);
  if (!record) return record.error();
  return std::get<Metadata>(std::move(*record));
}

Result<Record> decode(std::uint8_t opcode, std::span<const std::byte> content) {
  switch (static_cast<Opcode>(opcode)) {
    case Opcode::header:
      return decode_as<Header>(opcode, content);
    case Opcode::footer:
      return decode_as<Footer>(opcode, content);
    case Opcode::schema:
      return decode_as<Schema>(opcode, content);
    case Opcode::channel:
      return decode_as<Channel>(opcode, content);
    case Opcode::message:
      return decode_as<Message>(opcode, content);
    case Opcode::chunk:
      return decode_as<Chunk>(opcode, content);
    case Opcode::message_index:
      return decode_as<MessageIndex>(opcode, content);
    case Opcode::chunk_index:
      return decode_as<ChunkIndex>(opcode, content);
    case Opcode::attachment:
      return decode_as<Attachment>(opcode, content);
    case Opcode::attachment_index:
      return decode_as<AttachmentIndex>(opcode, content);
    case Opcode::statistics:
      return decode_as<Statistics>(opcode, content);
    case Opcode::metadata:
      return decode_as<Metadata>(opcode, content);
    case Opcode::metadata_index:
      return decode_as<MetadataIndex>(opcode, content);
    case Opcode::summary_offset:
      return decode_as<SummaryOffset>(opcode, content);
    case Opcode::data_end:
      return decode_as<DataEnd>(opcode, content);
    case Opcode::first_private:
      break;
  }
  return Record(OtherRecord{opcode, content});
}

std::string name_of(std::uint8_t opcode) {
  static constexpr const char* kNames[] = {
      "",         "header",         "footer",         "schema",     "channel",          "message",
      "chunk",    "message index",  "chunk index",    "attachment", "attachment index", "statistics",
      "metadata", "metadata index", "summary offset", "data end"};
  if (opcode >= 1 && opcode < std::size(kNames)) return kNames[opcode];
  char text[16];
  std::snprintf(text, sizeof text, "record 0x%02X", static_cast<unsigned>(opcode));
  return text;
}

}  // namespace roseau::mcap
