#include "recorder/tools/inspect/verification.h"

#include <fmt/format.h>

#include <map>
#include <optional>
#include <utility>

#include "recorder/format/file_io.h"
#include "recorder/format/stream_reader.h"
#include "recorder/format/topics.h"
#include "schema/conversion.h"

namespace roseau::recorder {

namespace {

constexpr std::size_t kMostProblems = 100;
constexpr std::uint64_t kProgressInterval = 256;

/// Tells how far reading has come.
class WatchedReadable : public mcap::Readable {
 public:
  explicit WatchedReadable(mcap::Readable& in) : in_(in) {}
  std::uint64_t size() const override { return in_.size(); }
  Result<void> read(std::uint64_t offset, std::span<std::byte> to) override {
    position_ = offset;
    return in_.read(offset, to);
  }
  double share() const { return static_cast<double>(position_) / static_cast<double>(in_.size()); }

 private:
  mcap::Readable& in_;
  std::uint64_t position_ = 0;
};

class Verifier {
 public:
  explicit Verifier(mcap::StreamReader& reader) : reader_(reader) {}

  void take(const mcap::Record& record) {
    if (const auto* channel = std::get_if<mcap::Channel>(&record)) {
      see_channel(*channel);
    } else if (const auto* message = std::get_if<mcap::Message>(&record)) {
      see_message(*message);
    } else if (std::get_if<mcap::Attachment>(&record) != nullptr) {
      ++found_.attachments;
    } else if (const auto* statistics = std::get_if<mcap::Statistics>(&record)) {
      see_statistics(*statistics);
    } else if (const auto* metadata = std::get_if<mcap::Metadata>(&record)) {
      see_metadata(*metadata);
    }
  }

  void problem(std::string text) {
    if (found_.problems.size() < kMostProblems) found_.problems.push_back(std::move(text));
    ++found_.problem_count;
  }

  Verification finish() {
    for (const auto& [id, stream] : streams_) {
      if (stream.out_of_order == 0) continue;
      problem(fmt::format("{}: {} inputs stand out of order (log time does not increase)", stream.topic, stream.out_of_order));
    }
    return std::move(found_);
  }

 private:
  struct Stream {
    std::string topic;
    std::optional<SampleKind> kind;
    std::uint64_t messages = 0;
    bool is_raw = false;
    std::optional<std::uint64_t> last_log_time_ns;
    std::uint64_t out_of_order = 0;
  };

  void see_channel(const mcap::Channel& channel) {
    if (streams_.contains(channel.id)) return;
    Stream stream;
    stream.topic = channel.topic;
    if (auto info = mcap::stream_info_from(channel, reader_.catalog().schema_of(channel)); info) {
      stream.kind = sample_kind_from_string(info->kind);
      stream.is_raw = info->role == StreamRole::raw;
      table_.add(std::move(*info));
    }
    streams_.emplace(channel.id, std::move(stream));
  }

  void see_message(const mcap::Message& message) {
    ++found_.messages;
    const auto entry = streams_.find(message.channel_id);
    if (entry == streams_.end()) return problem(fmt::format("message {} of an unknown channel", found_.messages));
    Stream& stream = entry->second;
    ++stream.messages;
    if (stream.is_raw) {
      // The order of inputs is what replay rests on. Streams stand in chunks of their own, so each is checked by itself.
      if (stream.last_log_time_ns && message.log_time_ns <= *stream.last_log_time_ns) ++stream.out_of_order;
      stream.last_log_time_ns = message.log_time_ns;
    }
    if (!stream.kind) return;
    if (auto parsed = check_payload(*stream.kind, message); !parsed) {
      problem(fmt::format("{}, sequence {}: {}", stream.topic, message.sequence, parsed.error().message));
    }
  }

  Result<void> check_payload(SampleKind kind, const mcap::Message& message) {
    if (kind == SampleKind::frame) {
      const auto view = schema::parse_frame(message.data, {});
      if (!view) return view.error();
      return {};
    }
    const auto sample = schema::parse(kind, message.data, {}, table_);
    if (!sample) return sample.error();
    return {};
  }

  void see_statistics(const mcap::Statistics& statistics) {
    if (statistics.message_count != found_.messages) {
      problem(fmt::format("the summary counts {} messages, the file holds {}", statistics.message_count, found_.messages));
    }
    for (const auto& [id, count] : statistics.channel_message_counts) {
      const auto entry = streams_.find(id);
      const std::uint64_t held = entry == streams_.end() ? 0 : entry->second.messages;
      const std::string topic = entry == streams_.end() ? fmt::format("channel {}", id) : entry->second.topic;
      if (held != count) problem(fmt::format("{}: the summary counts {} messages, the file holds {}", topic, count, held));
    }
  }

  void see_metadata(const mcap::Metadata& metadata) {
    if (metadata.name != mcap::kCountersMetadata) return;
    const auto counters = mcap::counters_from(metadata);
    if (!counters) return problem(counters.error().message);
    for (const auto& [id, stream] : streams_) {
      const auto counted = counters->find(stream.topic);
      if (counted == counters->end() || counted->second.recorded == stream.messages) continue;
      problem(fmt::format("{}: the recorder counted {} messages, the file holds {}", stream.topic, counted->second.recorded,
                          stream.messages));
    }
  }

  mcap::StreamReader& reader_;
  Verification found_;
  StreamTable table_;
  std::map<std::uint16_t, Stream> streams_;
};

}  // namespace

Result<Verification> verify_session(const std::filesystem::path& path, const std::function<void(double)>& progress) {
  auto file = mcap::FileReadable::open(path);
  if (!file) return file.error();
  if (auto magic = mcap::check_opening_magic(**file); !magic) return magic.error().with_context(path.string());
  WatchedReadable watched(**file);
  mcap::StreamReader reader(watched);
  Verifier verifier(reader);
  std::uint64_t records = 0;
  while (reader.can_continue()) {
    auto record = reader.next();
    if (!record) {
      verifier.problem(record.error().message);
    } else if (*record) {
      verifier.take(**record);
    } else {
      break;
    }
    if (progress && ++records % kProgressInterval == 0) progress(watched.share());
  }
  if (!reader.complete()) verifier.problem(reader.ending());
  Verification found = verifier.finish();
  found.is_complete = reader.complete();
  found.bytes = (*file)->size();
  return found;
}

}  // namespace roseau::recorder
