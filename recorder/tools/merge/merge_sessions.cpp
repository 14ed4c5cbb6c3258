#include "recorder/tools/merge/merge_sessions.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "schema/recorded_header.h"

namespace roseau::recorder {

namespace {

constexpr std::string_view kMergeMetadata = "roseau.merge";
constexpr std::uint64_t kProgressInterval = 256;

/// The messages of one file, their times on the first file's axis.
class Feed {
 public:
  Feed(const MergeInput& input, const CivilOffset& axis) : input_(input), axis_(axis), cursor_(input.reader->messages()) {
    if (!input.is_moved) return;
    for (const auto& [id, channel] : input.reader->catalog().channels()) {
      const auto info = mcap::stream_info_from(channel, input.reader->catalog().schema_of(channel));
      if (info) kinds_[id] = sample_kind_from_string(info->kind);
    }
  }

  /// False at the end. What cannot be read is noted and passed over.
  bool next(std::vector<std::string>& damage) {
    auto read = cursor_.next();
    for (; !read; read = cursor_.next()) {
      damage.push_back(fmt::format("{}: {}", input_.path.string(), read.error().message));
    }
    if (!*read) return false;
    message_ = (*read)->message;
    if (input_.is_moved) move();
    const auto channel = input_.channel_of.find(message_.channel_id);
    // A channel that the file's summary did not tell of: only in files of other programs, and broken ones.
    if (channel == input_.channel_of.end()) {
      damage.push_back(fmt::format("{}: a message of {} is left out: the file's summary does not know it", input_.path.string(),
                                   (*read)->channel->topic));
      return next(damage);
    }
    message_.channel_id = channel->second;
    return true;
  }

  const mcap::Message& message() const { return message_; }

 private:
  std::uint64_t moved_ns(std::uint64_t time_ns) const {
    return mcap::log_time_from(moved(mcap::host_time_from(time_ns), input_.civil_offset, axis_));
  }

  void move() {
    if (const auto kind = kinds_.find(message_.channel_id); kind != kinds_.end() && kind->second) move_header(*kind->second);
    message_.log_time_ns = moved_ns(message_.log_time_ns);
    message_.publish_time_ns = moved_ns(message_.publish_time_ns);
  }

  void move_header(SampleKind kind) {
    SampleHeader known;
    known.sequence = message_.sequence;
    known.arrival_time = mcap::host_time_from(message_.log_time_ns);
    known.sample_time = mcap::host_time_from(message_.publish_time_ns);
    const auto own = schema::read_header(kind, message_.data, known);
    if (!own) return;  // no message of this kind: it stays as it is, verify tells
    SampleHeader corrected = *own;
    corrected.arrival_time = moved(own->arrival_time, input_.civil_offset, axis_);
    corrected.sample_time = moved(own->sample_time, input_.civil_offset, axis_);
    data_.assign(message_.data.begin(), message_.data.end());
    schema::append_corrected_times(kind, corrected, *own, data_);
    message_.data = data_;
  }

  const MergeInput& input_;
  const CivilOffset& axis_;
  mcap::MessageCursor cursor_;
  std::map<std::uint16_t, std::optional<SampleKind>> kinds_;
  mcap::Message message_;
  std::vector<std::byte> data_;
};

/// The messages of the present log time, to recognise those that come twice.
class Recent {
 public:
  /// `lasting` are channels whose messages a cut carries along, at another log time: these are remembered for good.
  explicit Recent(std::set<std::uint16_t> lasting) : lasting_(std::move(lasting)) {}

  /// True: another file of the same session had it.
  bool is_repeated(const mcap::Message& message, std::size_t input) {
    if (lasting_.contains(message.channel_id)) return is_known(message);
    if (message.log_time_ns != time_ns_) {
      time_ns_ = message.log_time_ns;
      seen_.clear();
    }
    for (const Seen& seen : seen_) {
      if (seen.input != input && seen.channel_id == message.channel_id && seen.sequence == message.sequence &&
          seen.publish_time_ns == message.publish_time_ns && std::ranges::equal(seen.data, message.data)) {
        return true;
      }
    }
    // Only what has company at its time is ever compared, so copies are rare for pictures: one per log time.
    seen_.push_back({input, message.channel_id, message.sequence, message.publish_time_ns,
                     std::vector<std::byte>(message.data.begin(), message.data.end())});
    return false;
  }

 private:
  struct Seen {
    std::size_t input;
    std::uint16_t channel_id;
    std::uint32_t sequence;
    std::uint64_t publish_time_ns;
    std::vector<std::byte> data;
  };

  bool is_known(const mcap::Message& message) {
    const std::string text(reinterpret_cast<const char*>(message.data.data()), message.data.size());
    return !known_.emplace(message.channel_id, message.sequence, message.publish_time_ns, text).second;
  }

  std::set<std::uint16_t> lasting_;
  std::set<std::tuple<std::uint16_t, std::uint32_t, std::uint64_t, std::string>> known_;
  std::uint64_t time_ns_ = 0;
  std::vector<Seen> seen_;
};

class Merger {
 public:
  explicit Merger(MergePlan plan) : plan_(std::move(plan)) {}

  Result<MergeReport> run(const std::filesystem::path& out, const ToolProgress& progress) {
    auto output = SessionOutput::create(out, plan_.inputs.front().reader->index().header);
    if (!output) return output.error();
    output_ = output->get();
    describe();
    Result<void> done = write_head();
    if (done) done = write_messages(progress);
    if (done) done = write_note();
    if (done) done = output_->finish();
    if (!done) return done.error().with_context("the unfinished " + out.string() + " was removed");
    const auto& written = output_->statistics();
    report_.messages = written.message_count;
    report_.bytes = output_->bytes();
    report_.duration_s =
        to_seconds(Duration{static_cast<std::int64_t>(written.message_end_time_ns - written.message_start_time_ns)});
    return std::move(report_);
  }

 private:
  void describe() {
    report_.renamed = plan_.renamed;
    for (const MergeInput& input : plan_.inputs) {
      report_.inputs.push_back({.path = input.path, .host = input.host, .group = input.group, .moved_by = input.moved_by});
      for (const auto& damage : input.reader->index().damage) {
        report_.damage.push_back(fmt::format("{}: {}", input.path.string(), damage));
      }
    }
  }

  Result<void> write_head() {
    for (const MergeInput& input : plan_.inputs) {
      if (auto written = write_metadata(input); !written) return written;
      if (auto written = write_attachments(input); !written) return written;
    }
    for (const auto& schema : plan_.schemas) {
      if (auto written = output_->write(schema); !written) return written;
    }
    for (const auto& channel : plan_.channels) {
      const mcap::Schema* schema = channel.schema_id == 0 ? nullptr : &plan_.schemas[channel.schema_id - 1U];
      if (auto written = output_->write(channel, schema); !written) return written;
    }
    return {};
  }

  /// The first host's names stay; the others' stand behind their host's. Nothing stands twice under one name: a further part
  /// that says something else has its file's name in front.
  std::string name_for(const MergeInput& input, const std::string& name) {
    std::string kept = input.group == 0 ? name : input.host + "/" + name;
    if (!names_.contains(kept)) return kept;
    return input.path.stem().string() + "/" + name;
  }

  Result<void> write_metadata(const MergeInput& input) {
    const bool is_first = &input == &plan_.inputs.front();
    for (const auto& entry : input.reader->index().metadata) {
      auto metadata = input.reader->read(entry);
      if (!metadata) {
        report_.damage.push_back(fmt::format("{}: {}", input.path.string(), metadata.error().message));
        continue;
      }
      // Counters are counted anew; those of the sources stay to be read, each under its file's name.
      const bool is_counters = metadata->name == mcap::kCountersMetadata;
      if (is_counters) metadata->name = input.path.stem().string() + "/" + metadata->name;
      if (metadata->name == mcap::kSessionMetadata && is_first) metadata = session_of_all(*metadata);
      if (!metadata) return metadata.error();
      if (!is_counters && !is_first) metadata->name = name_for(input, metadata->name);
      if (!metadata_.insert({metadata->name, metadata->metadata}).second) continue;
      names_.insert(metadata->name);
      if (auto written = output_->write(*metadata); !written) return written;
    }
    return {};
  }

  /// The first file's word on the session, now that all of it is in one file.
  Result<mcap::Metadata> session_of_all(const mcap::Metadata& first) const {
    auto info = mcap::session_info_from(first);
    if (!info) return info.error();
    info->part = 1;
    info->repeated_messages = 0;
    std::set<std::size_t> groups{0};
    for (const MergeInput& input : plan_.inputs) {
      if (groups.insert(input.group).second && !input.info.session_id.empty()) info->session_id += "+" + input.info.session_id;
    }
    return mcap::to_metadata(*info);
  }

  Result<void> write_attachments(const MergeInput& input) {
    std::vector<std::byte> buffer;
    for (const auto& entry : input.reader->index().attachments) {
      auto attachment = input.reader->read(entry, buffer);
      if (!attachment) {
        report_.damage.push_back(fmt::format("{}: {}", input.path.string(), attachment.error().message));
        continue;
      }
      const std::string text(reinterpret_cast<const char*>(attachment->data.data()), attachment->data.size());
      // Parts of one session repeat theirs.
      if (!attachments_.insert({std::to_string(input.group) + attachment->name, text}).second) continue;
      attachment->name = name_for(input, attachment->name);
      names_.insert(attachment->name);
      if (auto written = output_->write(*attachment); !written) return written;
    }
    return {};
  }

  Result<void> write_messages(const ToolProgress& progress) {
    const CivilOffset& axis = plan_.inputs.front().civil_offset;
    std::vector<Feed> feeds;
    std::vector<bool> has_message;
    std::uint64_t expected = 0;
    for (const MergeInput& input : plan_.inputs) {
      feeds.emplace_back(input, axis);
      has_message.push_back(feeds.back().next(report_.damage));
      expected += input.reader->index().statistics.message_count;
    }
    Recent recent(lasting_channels());
    std::uint64_t last_log_time_ns = 0;
    for (std::uint64_t count = 0;; ++count) {
      std::optional<std::size_t> first;
      for (std::size_t i = 0; i < feeds.size(); ++i) {
        if (has_message[i] && (!first || feeds[i].message().log_time_ns < feeds[*first].message().log_time_ns)) first = i;
      }
      if (!first) return {};
      if (progress && count % kProgressInterval == 0 &&
          !progress(static_cast<double>(count) / static_cast<double>(std::max<std::uint64_t>(expected, 1)))) {
        report_.stopped = true;
        return {};
      }
      if (auto written = write_message(feeds[*first].message(), *first, recent, last_log_time_ns); !written) return written;
      has_message[*first] = feeds[*first].next(report_.damage);
    }
  }

  Result<void> write_message(mcap::Message message, std::size_t input, Recent& recent, std::uint64_t& last_log_time_ns) {
    ++report_.inputs[input].messages;
    if (shares_session(input) && recent.is_repeated(message, input)) {
      ++report_.inputs[input].duplicates;
      ++report_.duplicates;
      return {};
    }
    message.log_time_ns = std::max(message.log_time_ns, last_log_time_ns + 1);
    last_log_time_ns = message.log_time_ns;
    return output_->add(message);
  }

  std::set<std::uint16_t> lasting_channels() const {
    std::set<std::uint16_t> lasting;
    for (const auto& channel : plan_.channels) {
      const mcap::Schema* schema = channel.schema_id == 0 ? nullptr : &plan_.schemas[channel.schema_id - 1U];
      const auto info = mcap::stream_info_from(channel, schema);
      if (!info) continue;
      const auto kind = sample_kind_from_string(info->kind);
      if (kind == SampleKind::camera_calibration || kind == SampleKind::operator_action) lasting.insert(channel.id);
    }
    return lasting;
  }

  bool shares_session(std::size_t input) const {
    return std::ranges::count(plan_.inputs, plan_.inputs[input].group, &MergeInput::group) > 1;
  }

  Result<void> write_note() {
    mcap::Metadata note{std::string(kMergeMetadata), {}};
    for (const auto& input : report_.inputs) {
      note.metadata["source " + input.path.filename().string()] =
          fmt::format("host={} session={} messages={} duplicates={} moved_by={}", input.host, input.group + 1, input.messages,
                      input.duplicates, input.moved_by.empty() ? "0 s" : input.moved_by);
    }
    for (const auto& [from, to] : report_.renamed) note.metadata["topic " + from] = to;
    note.metadata["times"] =
        "on the axis of the first source; host_arrival_time and host_sample_time in a message's header are its own host's";
    return output_->write(note);
  }

  MergePlan plan_;
  SessionOutput* output_ = nullptr;
  MergeReport report_;
  std::set<std::string> names_;
  std::set<std::pair<std::string, mcap::StringMap>> metadata_;
  std::set<std::pair<std::string, std::string>> attachments_;
};

}  // namespace

Result<MergeReport> merge_sessions(const std::vector<std::filesystem::path>& files, const std::filesystem::path& out,
                                   const MergeOptions& options, const ToolProgress& progress) {
  auto plan = plan_merge(files, options);
  if (!plan) return plan.error();
  return Merger(std::move(*plan)).run(out, progress);
}

}  // namespace roseau::recorder
