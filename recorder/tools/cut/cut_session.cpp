#include "recorder/tools/cut/cut_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "recorder/format/codec.h"
#include "recorder/format/file_io.h"
#include "recorder/format/record_reader.h"
#include "schema/conversion.h"

namespace roseau::recorder {

namespace {

constexpr std::string_view kCutMetadata = "roseau.cut";
constexpr std::string_view kOwnProfile = "x-roseau";

std::string joined(const std::vector<std::string>& words) { return fmt::format("{}", fmt::join(words, " ")); }

struct Carried {
  mcap::Message message;
  std::vector<std::byte> data;
};

class Cutter {
 public:
  Cutter(mcap::IndexedReader& reader, mcap::Readable& file, Selection selection)
      : reader_(reader), file_(file), selection_(std::move(selection)) {}

  Result<CutReport> run(const std::filesystem::path& out, const mcap::Metadata& note, const ToolProgress& progress) {
    report_.damage = index().damage;
    if (auto found = find_carried(); !found) return found.error();
    auto output = SessionOutput::create(out, index().header);
    if (!output) return output.error();
    output_ = output->get();
    Result<void> done = write_head(note);
    if (done) done = write_blocks(progress);
    if (done) done = output_->finish();
    if (!done) return done.error().with_context("the unfinished " + out.string() + " was removed");
    finish_report();
    return std::move(report_);
  }

 private:
  const mcap::FileIndex& index() const { return reader_.index(); }

  std::optional<SampleKind> kind_of(const mcap::Channel& channel) const {
    const auto info = mcap::stream_info_from(channel, index().catalog.schema_of(channel));
    if (!info || info->role != StreamRole::raw) return std::nullopt;
    return sample_kind_from_string(info->kind);
  }

  /// The last calibration of each camera and the targets as they were at the start of the cut.
  Result<void> find_carried() {
    if (selection_.first_time_ns == 0) return {};
    mcap::MessageQuery query{.channels = std::vector<std::uint16_t>{}, .end_time_ns = selection_.first_time_ns - 1};
    for (const std::uint16_t id : selection_.channels) {
      const auto kind = kind_of(*index().catalog.channel(id));
      if (kind == SampleKind::camera_calibration || kind == SampleKind::operator_action) query.channels->push_back(id);
    }
    if (query.channels->empty()) return {};
    auto messages = reader_.messages(query);
    for (auto message = messages.next(); !message || *message; message = messages.next()) {
      if (message) {
        see_earlier(**message);
      } else {
        report_.damage.push_back(message.error().message);
      }
    }
    return {};
  }

  void see_earlier(const mcap::ReadMessage& read) {
    std::string key = read.channel->topic;
    if (kind_of(*read.channel) == SampleKind::operator_action) {
      const auto sample = schema::parse(SampleKind::operator_action, read.message.data, {}, no_streams_);
      if (!sample) return;
      const auto& action = std::get<OperatorAction>(sample->payload);
      const bool adds = action.kind == OperatorAction::Kind::add_target;
      if (!adds && action.kind != OperatorAction::Kind::remove_target) return;
      key += '\n' + action.camera + '\n' + action.text;
      carried_.erase(key);
      if (!adds) return;
    }
    carried_.erase(key);
    Carried& carried = carried_[key];
    carried.message = read.message;
    carried.data.assign(read.message.data.begin(), read.message.data.end());
  }

  Result<void> write_head(const mcap::Metadata& note) {
    if (auto written = write_metadata(note); !written) return written;
    std::vector<std::byte> buffer;
    for (const auto& entry : index().attachments) {
      const auto attachment = reader_.read(entry, buffer);
      if (!attachment) {
        report_.damage.push_back(attachment.error().message);
        continue;
      }
      if (auto written = output_->write(*attachment); !written) return written;
    }
    std::set<std::uint16_t> schemas;
    for (const std::uint16_t id : selection_.channels) {
      const mcap::Channel& channel = *index().catalog.channel(id);
      const mcap::Schema* schema = index().catalog.schema_of(channel);
      if (schema != nullptr && schemas.insert(schema->id).second) {
        if (auto written = output_->write(*schema); !written) return written;
      }
      if (auto written = output_->write(channel, schema); !written) return written;
    }
    return write_carried();
  }

  /// Everything but the counters, which are counted anew. What the source counted goes into the note.
  Result<void> write_metadata(const mcap::Metadata& cut) {
    mcap::Metadata note = cut;
    for (const auto& entry : index().metadata) {
      const auto metadata = reader_.read(entry);
      if (!metadata) {
        report_.damage.push_back(metadata.error().message);
        continue;
      }
      if (metadata->name == mcap::kCountersMetadata) {
        for (const auto& [topic, text] : metadata->metadata) note.metadata["source counters " + topic] = text;
        continue;
      }
      if (metadata->name == mcap::kSessionMetadata) {
        if (auto written = write_session(*metadata); !written) return written;
        continue;
      }
      if (auto written = output_->write(*metadata); !written) return written;
    }
    return output_->write(note);
  }

  /// As the source says it, with what this file repeats from before its start: who joins cuts leaves it out.
  Result<void> write_session(const mcap::Metadata& source) {
    auto info = mcap::session_info_from(source);
    if (!info) return info.error();
    const bool has_front = selection_.first_time_ns <= index().statistics.message_start_time_ns;
    info->repeated_messages = has_front ? wanted_of_front(info->repeated_messages) : 0;
    info->repeated_messages += static_cast<std::uint32_t>(carried_.size());
    return output_->write(mcap::to_metadata(*info));
  }

  /// How many of the first `count` messages of the source are of wanted channels.
  std::uint32_t wanted_of_front(std::uint32_t count) {
    std::uint32_t wanted = 0;
    auto messages = reader_.messages();
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto message = messages.next();
      if (!message || !*message) break;
      if (selection_.holds_channel((*message)->message.channel_id)) ++wanted;
    }
    return wanted;
  }

  Result<void> write_carried() {
    std::vector<const Carried*> in_order;
    for (const auto& [key, carried] : carried_) in_order.push_back(&carried);
    std::ranges::sort(in_order, {}, [](const Carried* carried) { return carried->message.log_time_ns; });
    std::uint64_t log_time_ns = selection_.first_time_ns - std::min(selection_.first_time_ns, std::uint64_t{in_order.size()});
    for (const Carried* carried : in_order) {
      mcap::Message message = carried->message;
      message.data = carried->data;
      message.log_time_ns = log_time_ns++;
      output_->count_repeated(message.channel_id);
      if (auto added = output_->add(message); !added) return added;
    }
    report_.carried = in_order.size();
    return {};
  }

  Result<void> write_blocks(const ToolProgress& progress) {
    // In the order of the file, not of time: what lies beside each other stays so.
    std::vector<mcap::MessageBlock> blocks = index().blocks;
    std::ranges::sort(blocks, {}, &mcap::MessageBlock::offset);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      if (progress && !progress(static_cast<double>(i) / static_cast<double>(blocks.size()))) {
        report_.stopped = true;
        return {};
      }
      if (!may_hold(blocks[i])) continue;
      if (auto written = write_block(blocks[i]); !written) return written;
    }
    return {};
  }

  bool may_hold(const mcap::MessageBlock& block) const {
    if (block.end_time_ns < selection_.first_time_ns || block.start_time_ns > selection_.last_time_ns) return false;
    return !block.channels ||
           std::ranges::any_of(*block.channels, [this](std::uint16_t id) { return selection_.holds_channel(id); });
  }

  /// Errors are those of writing; what cannot be read is noted and passed over.
  Result<void> write_block(const mcap::MessageBlock& block) {
    auto records = read_records(block);
    Result<void> walked = records ? walk(*records) : Result<void>(records.error());
    if (!walked) {
      report_.damage.push_back(fmt::format("the {} at byte {} is left out: {}", block.is_chunk ? "chunk" : "run of messages",
                                           block.offset, walked.error().message));
      return {};
    }
    if (kept_.empty()) return {};
    // Files of other programs may describe channels inside chunks: with all channels wanted these do no harm.
    const bool knows_all =
        index().header.profile == kOwnProfile || selection_.channels.size() == index().catalog.channels().size();
    if (block.is_chunk && all_kept_ && knows_all) {
      ++report_.chunks_copied;
      for (const auto& message : kept_) output_->count(message);
      return output_->copy_chunk(chunk_, *records);
    }
    ++report_.chunks_rebuilt;
    for (const auto& message : kept_) {
      if (auto added = output_->add(message); !added) return added;
    }
    return {};
  }

  Result<std::span<const std::byte>> read_records(const mcap::MessageBlock& block) {
    if (block.length > file_.size() || block.offset > file_.size() - block.length) {
      return Error{ErrorCode::corrupt, "the index points outside of the file"};
    }
    stored_.resize(block.length);
    if (auto read = file_.read(block.offset, stored_); !read) return read.error();
    if (!block.is_chunk) return std::span<const std::byte>(stored_);
    const auto record = mcap::decode(static_cast<std::uint8_t>(stored_[0]), std::span(stored_).subspan(mcap::kRecordHeadBytes));
    if (!record) return record.error();
    const auto* chunk = std::get_if<mcap::Chunk>(&*record);
    if (chunk == nullptr) return Error{ErrorCode::corrupt, "there is no chunk where the index says"};
    chunk_ = *chunk;
    return mcap::chunk_records(chunk_, decompressed_, {});
  }

  /// The wanted messages, and whether they are all.
  Result<void> walk(std::span<const std::byte> records) {
    kept_.clear();
    all_kept_ = true;
    std::uint64_t position = 0;
    while (true) {
      const auto place = mcap::next_record(records, position);
      if (!place) return place.error();
      if (!*place) return {};
      if ((*place)->opcode != static_cast<std::uint8_t>(mcap::Opcode::message)) continue;
      const auto record = mcap::decode((*place)->opcode, records.subspan((*place)->content_offset(), (*place)->content_bytes));
      if (!record) return record.error();
      const auto& message = std::get<mcap::Message>(*record);
      if (!selection_.holds_time(message.log_time_ns) || !selection_.holds_channel(message.channel_id)) {
        all_kept_ = false;
        continue;
      }
      kept_.push_back(message);
    }
  }

  void finish_report() {
    const auto& written = output_->statistics();
    const auto begin_ns = static_cast<std::int64_t>(index().statistics.message_start_time_ns);
    const auto seconds = [begin_ns](std::uint64_t time_ns) {
      return to_seconds(Duration{static_cast<std::int64_t>(time_ns) - begin_ns});
    };
    report_.messages = written.message_count;
    report_.bytes = output_->bytes();
    report_.begin_s = written.message_count == 0 ? 0 : seconds(written.message_start_time_ns);
    report_.end_s = written.message_count == 0 ? 0 : seconds(written.message_end_time_ns);
    report_.begins_in_mid_run = selection_.first_time_ns > index().statistics.message_start_time_ns;
  }

  mcap::IndexedReader& reader_;
  mcap::Readable& file_;
  Selection selection_;
  SessionOutput* output_ = nullptr;
  CutReport report_;
  StreamTable no_streams_;
  std::map<std::string, Carried> carried_;  // by topic, and target where it is one

  // Of the block at hand; reused.
  std::vector<std::byte> stored_;
  std::vector<std::byte> decompressed_;
  std::vector<mcap::Message> kept_;
  mcap::Chunk chunk_;  // a view of stored_
  bool all_kept_ = true;
};

mcap::Metadata note_of(const std::filesystem::path& in, const SelectionOptions& options, const Selection& selection,
                       const mcap::FileIndex& index) {
  const auto& whole = index.statistics;
  mcap::Metadata note{std::string(kCutMetadata), {}};
  note.metadata = {{"source", in.filename().string()},
                   {"first_log_time_ns", std::to_string(std::max(selection.first_time_ns, whole.message_start_time_ns))},
                   {"last_log_time_ns", std::to_string(std::min(selection.last_time_ns, whole.message_end_time_ns))},
                   {"source_first_log_time_ns", std::to_string(whole.message_start_time_ns)},
                   {"source_last_log_time_ns", std::to_string(whole.message_end_time_ns)},
                   {"source_messages", std::to_string(whole.message_count)},
                   {"topics", joined(options.topics)},
                   {"without", joined(options.without)}};
  return note;
}

}  // namespace

Result<CutReport> cut_session(const std::filesystem::path& in, const std::filesystem::path& out,
                              const SelectionOptions& options, const ToolProgress& progress) {
  auto reader = mcap::IndexedReader::open(in);
  if (!reader) return reader.error();
  auto file = mcap::FileReadable::open(in);
  if (!file) return file.error();
  const auto info = read_session_info(**reader);
  if (!info) return info.error().with_context(in.string());
  auto selection = select(options, (*reader)->index(), info->utc_minus_host_time);
  if (!selection) return selection.error().with_context(in.string());
  const auto note = note_of(in, options, *selection, (*reader)->index());
  return Cutter(**reader, **file, std::move(*selection)).run(out, note, progress);
}

}  // namespace roseau::recorder
