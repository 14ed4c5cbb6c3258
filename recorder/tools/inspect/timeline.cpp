#include "recorder/tools/inspect/timeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "recorder/format/codec.h"
#include "recorder/format/file_io.h"
#include "recorder/format/topics.h"
#include "schema/conversion.h"

namespace roseau::recorder {

namespace {

constexpr std::size_t kLabelWidth = 30;
constexpr std::size_t kMostEvents = 2000;  // marks, gaps and drops that are read one by one
constexpr std::size_t kMostMarksSaid = 40;
constexpr std::size_t kIndexRead_bytes = 4096;

class TimelineMaker {
 public:
  TimelineMaker(mcap::IndexedReader& reader, mcap::Readable& file, std::size_t slices)
      : reader_(reader), file_(file), slices_(slices) {}

  Result<Timeline> make() {
    const auto& index = reader_.index();
    timeline_.begin = mcap::host_time_from(index.statistics.message_start_time_ns);
    timeline_.end = mcap::host_time_from(index.statistics.message_end_time_ns);
    for (const auto& [id, channel] : index.catalog.channels()) {
      const auto info = mcap::stream_info_from(channel, index.catalog.schema_of(channel));
      if (info) kinds_[id] = sample_kind_from_string(info->kind);
      lines_[id] = {.topic = channel.topic, .slices = std::vector<Timeline::Slice>(slices_)};
    }
    for (const auto& block : index.blocks) {
      if (auto counted = count(block); !counted) return counted.error();
    }
    read_health();
    read_events();
    for (auto& [id, line] : lines_) timeline_.lines.push_back(std::move(line));
    std::ranges::sort(timeline_.lines, {}, &Timeline::Line::topic);
    std::ranges::sort(timeline_.marks, {}, &Timeline::Mark::time_s);
    return std::move(timeline_);
  }

 private:
  std::size_t slice_of(std::uint64_t time_ns) const {
    const double span_s = to_seconds(timeline_.end - timeline_.begin);
    if (span_s <= 0) return 0;
    const double share = to_seconds(mcap::host_time_from(time_ns) - timeline_.begin) / span_s;
    return std::min(slices_ - 1, static_cast<std::size_t>(std::max(0.0, share) * static_cast<double>(slices_)));
  }

  /// By the message indexes behind the chunk. Where there are none, by what the block itself says: something, in its span.
  Result<void> count(const mcap::MessageBlock& block) {
    std::uint64_t position = block.offset + block.length;
    bool has_indexes = false;
    std::size_t wanted = kIndexRead_bytes;
    while (block.is_chunk && position + mcap::kRecordHeadBytes <= file_.size()) {
      bytes_.resize(std::min<std::uint64_t>(wanted, file_.size() - position));
      if (auto read = file_.read(position, bytes_); !read) return read;
      std::size_t used = 0;
      const auto ending = count_indexes(used);
      has_indexes = has_indexes || used > 0;
      if (ending == Ending::other_record) break;
      position += used;
      if (used == 0 && bytes_.size() < wanted) break;  // cut off
      wanted = ending == Ending::needs_more ? std::max<std::size_t>(needed_, kIndexRead_bytes) : kIndexRead_bytes;
    }
    if (!has_indexes && block.channels) {
      for (const std::uint16_t id : *block.channels) {
        for (std::size_t i = slice_of(block.start_time_ns); i <= slice_of(block.end_time_ns); ++i)
          ++lines_[id].slices[i].messages;
      }
    }
    return {};
  }

  enum class Ending { other_record, needs_more };
  Ending count_indexes(std::size_t& used) {
    const std::span<const std::byte> bytes(bytes_);
    while (bytes.size() - used >= mcap::kRecordHeadBytes) {
      const auto head = mcap::decode_head(bytes.subspan(used));
      if (head.opcode != static_cast<std::uint8_t>(mcap::Opcode::message_index)) return Ending::other_record;
      if (head.content_bytes > file_.size()) return Ending::other_record;
      needed_ = mcap::kRecordHeadBytes + head.content_bytes;
      if (bytes.size() - used < needed_) return Ending::needs_more;
      const auto record = mcap::decode(head.opcode, bytes.subspan(used + mcap::kRecordHeadBytes, head.content_bytes));
      if (!record) return Ending::other_record;
      see(std::get<mcap::MessageIndex>(*record));
      used += needed_;
    }
    needed_ = mcap::kRecordHeadBytes;
    return Ending::needs_more;
  }

  void see(const mcap::MessageIndex& index) {
    const auto line = lines_.find(index.channel_id);
    if (line == lines_.end()) return;
    const auto kind = kinds_.find(index.channel_id);
    const bool is_health = kind != kinds_.end() && kind->second == SampleKind::health;
    for (const auto& [time_ns, offset] : index.entries) {
      const std::size_t slice = slice_of(time_ns);
      ++line->second.slices[slice].messages;
      if (is_health) last_health_[slice] = std::max(last_health_[slice], time_ns);
    }
  }

  std::vector<std::uint16_t> channels_of(std::initializer_list<SampleKind> kinds) const {
    std::vector<std::uint16_t> channels;
    for (const auto& [id, kind] : kinds_) {
      if (kind && std::ranges::find(kinds, *kind) != kinds.end()) channels.push_back(id);
    }
    return channels;
  }

  Timeline::Slice* slice(const std::string& topic, std::size_t at) {
    for (auto& [id, line] : lines_) {
      if (line.topic == topic) return &line.slices[at];
    }
    return nullptr;
  }

  /// The counters at the end of each slice: what rose within it.
  void read_health() {
    std::map<std::string, StreamCounters> before;
    for (const auto& [at, time_ns] : last_health_) {
      auto messages =
          reader_.messages({.channels = channels_of({SampleKind::health}), .start_time_ns = time_ns, .end_time_ns = time_ns});
      const auto message = messages.next();
      if (!message || !*message) continue;
      const auto sample = schema::parse(SampleKind::health, (*message)->message.data, {}, no_streams_);
      if (!sample) continue;
      for (const auto& stream : std::get<Health>(sample->payload).streams) {
        const StreamCounters now = stream.counters;
        const StreamCounters was = std::exchange(before[stream.topic], now);
        Timeline::Slice* into = slice(stream.topic, at);
        if (into == nullptr) continue;
        into->has_gaps |= now.gaps > was.gaps;
        into->has_drops |= now.dropped > was.dropped;
        into->has_bad |= now.bad > was.bad;
      }
    }
  }

  /// Marks and triggers, gaps and drops: few, in small chunks.
  void read_events() {
    const auto channels = channels_of({SampleKind::operator_action, SampleKind::gap, SampleKind::drop});
    if (channels.empty()) return;
    auto messages = reader_.messages({.channels = channels});
    for (std::size_t count = 0; count < kMostEvents; ++count) {
      const auto message = messages.next();
      if (!message) continue;
      if (!*message) return;
      const auto& record = (*message)->message;
      const auto sample = schema::parse(*kinds_.at(record.channel_id), record.data, {}, no_streams_);
      if (sample) see_event(*sample, record.log_time_ns);
    }
  }

  void see_event(const Sample& sample, std::uint64_t time_ns) {
    const std::size_t at = slice_of(time_ns);
    if (const auto* gap = std::get_if<Gap>(&sample.payload)) {
      if (Timeline::Slice* into = slice(gap->topic, at)) into->has_gaps = true;
    } else if (const auto* drop = std::get_if<Drop>(&sample.payload)) {
      if (Timeline::Slice* into = slice(drop->topic, at)) into->has_drops = true;
    } else if (const auto* action = std::get_if<OperatorAction>(&sample.payload)) {
      constexpr std::array<std::string_view, 7> kWords = {
          "mark", "target", "target removed", "recording started", "recording ended", "note", "trigger"};
      const auto kind = static_cast<std::size_t>(action->kind);
      timeline_.marks.push_back(
          {.time_s = to_seconds(mcap::host_time_from(time_ns) - timeline_.begin),
           .is_trigger = action->kind == OperatorAction::Kind::trigger,
           .text = fmt::format("{}{}", kWords.at(kind), action->text.empty() ? "" : " '" + action->text + "'")});
    }
  }

  mcap::IndexedReader& reader_;
  mcap::Readable& file_;
  std::size_t slices_;
  Timeline timeline_;
  StreamTable no_streams_;
  std::map<std::uint16_t, std::optional<SampleKind>> kinds_;
  std::map<std::uint16_t, Timeline::Line> lines_;
  std::map<std::size_t, std::uint64_t> last_health_;  // by slice: log time of its last health sample
  std::vector<std::byte> bytes_;
  std::size_t needed_ = 0;
};

}  // namespace

Result<Timeline> make_timeline(const std::filesystem::path& path, mcap::IndexedReader& reader, std::size_t slices) {
  auto file = mcap::FileReadable::open(path);
  if (!file) return file.error();
  return TimelineMaker(reader, **file, std::max<std::size_t>(slices, 1)).make();
}

std::string line_text(const Timeline::Line& line, TimelineStyle style) {
  constexpr std::array<std::string_view, 8> kBlocks = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  constexpr std::array<std::string_view, 8> kAscii = {".", ":", "-", "=", "+", "*", "%", "#"};
  const auto& levels = style == TimelineStyle::blocks ? kBlocks : kAscii;
  std::uint64_t most = 1;
  for (const auto& slice : line.slices) most = std::max(most, slice.messages);
  std::string text;
  for (const auto& slice : line.slices) {
    if (slice.has_bad) {
      text += "b";
    } else if (slice.has_drops) {
      text += "d";
    } else if (slice.has_gaps) {
      text += "g";
    } else {
      text += slice.messages == 0 ? " " : levels[(slice.messages * levels.size() - 1) / most];
    }
  }
  return text;
}

std::size_t slices_in(std::size_t width) { return width > kLabelWidth + 10 ? width - kLabelWidth - 2 : 8; }

std::string to_text(const Timeline& timeline, TimelineStyle style) {
  std::string text = fmt::format("timeline, {:.3g} s per character (g: gaps, d: dropped, b: bad data)\n", timeline.slice_s());
  for (const auto& line : timeline.lines) {
    std::string label = line.topic;
    if (label.size() > kLabelWidth) label = ".." + label.substr(label.size() - kLabelWidth + 2);
    text += fmt::format("{:<{}} |{}\n", label, kLabelWidth, line_text(line, style));
  }
  if (timeline.marks.empty() || timeline.lines.empty()) return text;
  std::string marks(timeline.lines[0].slices.size(), ' ');
  for (const auto& mark : timeline.marks) {
    const double slice = timeline.slice_s() > 0 ? mark.time_s / timeline.slice_s() : 0;
    char& at = marks[std::min(marks.size() - 1, static_cast<std::size_t>(std::max(0.0, slice)))];
    if (at != 'T') at = mark.is_trigger ? 'T' : '^';
  }
  text += fmt::format("{:<{}} |{}\n", "marks (^), triggers (T)", kLabelWidth, marks);
  for (std::size_t i = 0; i < std::min(timeline.marks.size(), kMostMarksSaid); ++i) {
    text += fmt::format("  {:9.3f} s  {}\n", timeline.marks[i].time_s, timeline.marks[i].text);
  }
  if (timeline.marks.size() > kMostMarksSaid) text += fmt::format("  and {} more\n", timeline.marks.size() - kMostMarksSaid);
  return text;
}

}  // namespace roseau::recorder
