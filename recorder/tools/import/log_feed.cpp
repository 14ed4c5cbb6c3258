#include "recorder/tools/import/log_feed.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <numbers>
#include <utility>

#include "drivers/wire/nmea0183.h"
#include "drivers/wire/trisonica.h"
#include "recorder/tools/import/log_clock.h"

namespace roseau::recorder {

namespace {

/// What a log's lines say, looked at once, so that their decoder can be set up.
class LogContent {
 public:
  virtual ~LogContent() = default;
  virtual void observe(std::string_view line) = 0;
  /// Civil time that a line tells, if it does.
  virtual std::optional<Duration> sentence_time(std::string_view) const { return std::nullopt; }
  /// The raw stream, once all was observed. Error: nothing of the instrument was found.
  virtual Result<StreamInfo> stream(double rate_hz) const = 0;
  virtual std::vector<std::string> remarks() const = 0;
};

std::string_view without_line_end(std::string_view line) {
  const auto begin = line.find_first_not_of("\r\n");
  if (begin == std::string_view::npos) return {};
  return line.substr(begin, line.find_last_not_of("\r\n") - begin + 1);
}

class TriSonicaContent : public LogContent {
 public:
  explicit TriSonicaContent(const ImportPlan::Sonic& sonic) : sonic_(sonic) {}

  void observe(std::string_view line) override {
    const auto layout = wire::TriSonicaLayout::of_line(line);
    if (!layout) return;
    auto text = layout->text();
    if (counts_.size() < kMostLayouts || counts_.contains(text)) ++counts_[std::move(text)];
    const auto heading = layout->find("MD");
    if (!heading) return;
    const double heading_rad = (*wire::parse_trisonica(line, *layout))[*heading] * std::numbers::pi / 180;
    if (!std::isfinite(heading_rad)) return;
    ++headings_;
    north_ += std::cos(heading_rad);
    east_ += std::sin(heading_rad);
  }
  Result<StreamInfo> stream(double rate_hz) const override {
    if (counts_.empty()) {
      return Error{ErrorCode::corrupt, sonic_.path + ": no line of a TriSonica (tags and values, like U  02.142 V  00.592)"};
    }
    return wire::raw_stream(sonic_.name,
                            wire::TriSonicaOptions{.layout = wire::TriSonicaLayout::parse(most_common()).value(),
                                                   .north_offset_deg = sonic_.north_offset_deg,
                                                   .rate_hz = rate_hz},
                            "file " + sonic_.path);
  }
  std::vector<std::string> remarks() const override {
    std::vector<std::string> remarks = {"lines hold " + most_common()};
    if (headings_ > 0) {
      const double mean_deg = std::atan2(east_, north_) * 180 / std::numbers::pi;
      remarks.push_back(
          fmt::format("its compass (MD) points to {:.1f} degrees magnetic on average; north offset in use: {} degrees",
                      mean_deg < 0 ? mean_deg + 360 : mean_deg, sonic_.north_offset_deg));
    }
    return remarks;
  }

 private:
  static constexpr std::size_t kMostLayouts = 64;
  std::string most_common() const {
    return std::ranges::max_element(counts_, {}, [](const auto& entry) { return entry.second; })->first;
  }

  const ImportPlan::Sonic sonic_;
  std::map<std::string, std::uint64_t> counts_;
  std::uint64_t headings_ = 0;
  double north_ = 0;
  double east_ = 0;
};

class NmeaContent : public LogContent {
 public:
  explicit NmeaContent(const ImportPlan::Sonic& sonic) : sonic_(sonic) {}

  void observe(std::string_view line) override {
    const auto body = wire::nmea_body(line, false);
    if (!body) return;
    ++(line.find('*') == std::string_view::npos ? without_checksum_ : with_checksum_);
    for (std::size_t i = 0; i < kSources.size(); ++i) {
      if (!wire::is_foreign_to_nmea_wind(*body, kSources.at(i)) && wire::parse_nmea_wind(*body, kSources.at(i))) ++winds_.at(i);
    }
  }
  std::optional<Duration> sentence_time(std::string_view line) const override {
    const auto body = wire::nmea_body(line, false);
    return body ? wire::parse_nmea_time(*body) : std::nullopt;
  }
  Result<StreamInfo> stream(double rate_hz) const override {
    if (!source())
      return Error{ErrorCode::corrupt, sonic_.path + ": no sentence with wind (MWV, MDA, or XDR with an angle and a speed)"};
    return wire::raw_stream(sonic_.name,
                            wire::NmeaOptions{.source = *source(),
                                              .requires_checksum = with_checksum_ > 0,
                                              .north_offset_deg = sonic_.north_offset_deg,
                                              .rate_hz = rate_hz},
                            "file " + sonic_.path);
  }
  std::vector<std::string> remarks() const override {
    std::vector<std::string> remarks;
    if (source()) remarks.push_back(fmt::format("wind from the sentences {}", wire::to_string(*source())));
    if (with_checksum_ == 0) {
      remarks.emplace_back("no sentence has a checksum: taken without");
    } else if (without_checksum_ > 0) {
      remarks.push_back(fmt::format("{} sentences without a checksum count as damaged", without_checksum_));
    }
    return remarks;
  }

 private:
  // In the order in which they are preferred.
  static constexpr std::array kSources = {wire::NmeaWindSource::mwv_relative, wire::NmeaWindSource::mwv_true,
                                          wire::NmeaWindSource::mda, wire::NmeaWindSource::xdr};
  std::optional<wire::NmeaWindSource> source() const {
    for (std::size_t i = 0; i < kSources.size(); ++i) {
      if (winds_.at(i) > 0) return kSources.at(i);
    }
    return std::nullopt;
  }

  const ImportPlan::Sonic sonic_;
  std::array<std::uint64_t, kSources.size()> winds_{};
  std::uint64_t with_checksum_ = 0;
  std::uint64_t without_checksum_ = 0;
};

class LogFeed : public ImportFeed {
 public:
  LogFeed(std::unique_ptr<LogReader> log, std::unique_ptr<LogContent> content, Duration start_offset, std::string path)
      : log_(std::move(log)), content_(std::move(content)), start_offset_(start_offset), path_(std::move(path)) {}

  Result<void> survey(std::optional<double> rate_hz);

  std::optional<Duration> begin() const override {
    return clock_.is_civil() ? std::optional(clock_.first_time()) : std::nullopt;
  }
  Duration start_offset() const override { return start_offset_; }
  Result<void> start(HostTime start, StreamTable& streams) override {
    start_ = start;
    stream_ = streams.add(info_);
    return {};
  }
  Result<std::optional<HostTime>> next_time() override;
  Sample take() override;
  double share() const override { return log_->share(); }
  std::vector<ImportReport::Stream> describe() const override {
    return {{.topic = info_.topic, .path = path_, .rate_hz = rate_hz_, .remarks = remarks_}};
  }

 private:
  struct Piece {
    Duration time{0};
    std::string bytes;
  };

  Result<bool> read_piece(Piece& piece);
  Result<void> read_group();
  void spread(std::optional<Duration> next_time);

  std::unique_ptr<LogReader> log_;
  std::unique_ptr<LogContent> content_;
  Duration start_offset_;
  std::string path_;
  LogClock clock_;
  StreamInfo info_;
  double rate_hz_ = 0;
  std::vector<std::string> remarks_;
  HostTime start_;
  StreamId stream_ = 0;
  std::deque<Piece> group_;      // lines of one time, spread
  std::optional<Piece> behind_;  // the first line of the next
  std::uint32_t samples_ = 0;
};

Result<void> LogFeed::survey(std::optional<double> rate_hz) {
  if (auto rewound = log_->rewind(); !rewound) return rewound;
  LogEntry entry;
  for (auto more = log_->next(entry); !more || *more; more = log_->next(entry)) {
    if (!more) return more.error();
    const auto line = without_line_end(entry.bytes);
    clock_.observe(entry, content_->sentence_time(line));
    content_->observe(line);
  }
  const bool was_cut = log_->was_cut();
  if (clock_.entries() == 0) return Error{ErrorCode::corrupt, path_ + ": no lines"};
  // What the lines are matters more than when they came.
  if (auto checked = content_->stream(1); !checked) return checked.error();
  if (auto settled = clock_.settle(rate_hz, path_); !settled) return settled;

  // How long it lasts is only known once every entry had its time.
  if (auto rewound = log_->rewind(); !rewound) return rewound;
  Duration last = clock_.first_time();
  std::uint64_t entries = 0;
  for (auto more = log_->next(entry); !more || *more; more = log_->next(entry)) {
    if (!more) return more.error();
    last = clock_.time_of(entry, content_->sentence_time(without_line_end(entry.bytes)));
    ++entries;
  }
  const double span_s = to_seconds(last - clock_.first_time());
  rate_hz_ = span_s > 0 ? static_cast<double>(entries - 1) / span_s : rate_hz.value_or(0);
  // An instrument is set to a whole number of hertz; the logger's clock is not that good.
  const bool is_whole = std::abs(rate_hz_ - std::round(rate_hz_)) < 1e-3 * rate_hz_;
  auto info = content_->stream(rate_hz.value_or(is_whole ? std::round(rate_hz_) : rate_hz_));
  if (!info) return info.error();
  info_ = std::move(*info);
  remarks_ = content_->remarks();
  const auto times = clock_.remarks();
  remarks_.insert(remarks_.end(), times.begin(), times.end());
  if (was_cut) remarks_.emplace_back("the last line is cut short");
  clock_.begin_pass();
  return log_->rewind();
}

Result<bool> LogFeed::read_piece(Piece& piece) {
  LogEntry entry;
  auto more = log_->next(entry);
  while (more && *more && entry.bytes.empty()) more = log_->next(entry);
  if (!more || !*more) return more;
  piece.time = clock_.time_of(entry, content_->sentence_time(without_line_end(entry.bytes)));
  piece.bytes = std::move(entry.bytes);
  return true;
}

// All lines that share one time, up to the first of the next.
Result<void> LogFeed::read_group() {
  if (behind_) group_.push_back(*std::exchange(behind_, std::nullopt));
  while (group_.size() < LogClock::kMostSpread) {
    Piece piece;
    const auto more = read_piece(piece);
    if (!more) return more.error();
    if (!*more) break;
    if (!group_.empty() && piece.time != group_.front().time) {
      behind_ = std::move(piece);
      break;
    }
    group_.push_back(std::move(piece));
  }
  spread(behind_ ? std::optional(behind_->time) : std::nullopt);
  return {};
}

void LogFeed::spread(std::optional<Duration> next_time) {
  const bool is_spread = clock_.kind() == LogClock::Kind::stamps || clock_.kind() == LogClock::Kind::sentences;
  if (!is_spread || group_.size() < 2 || group_.size() == LogClock::kMostSpread) return;
  auto step = clock_.resolution();
  if (next_time) step = std::min(step, *next_time - group_.front().time);
  const auto count = static_cast<Duration::rep>(group_.size());
  for (Duration::rep i = 1; i < count; ++i) group_[static_cast<std::size_t>(i)].time += step * i / count;
}

Result<std::optional<HostTime>> LogFeed::next_time() {
  if (group_.empty()) {
    if (auto read = read_group(); !read) return read.error();
  }
  if (group_.empty()) return std::optional<HostTime>();
  return std::optional(start_ + (group_.front().time - clock_.first_time()));
}

// A line longer than what a sample holds comes in several.
Sample LogFeed::take() {
  auto& piece = group_.front();
  RawBytes raw;
  raw.size = static_cast<std::uint16_t>(std::min(piece.bytes.size(), RawBytes::kCapacity));
  std::transform(piece.bytes.begin(), piece.bytes.begin() + raw.size, raw.storage.begin(),
                 [](char c) { return static_cast<std::byte>(c); });
  Sample sample;
  sample.header.stream = stream_;
  sample.header.sequence = samples_++;
  sample.header.arrival_time = start_ + (piece.time - clock_.first_time());
  sample.header.sample_time = sample.header.arrival_time;
  sample.payload = raw;
  piece.bytes.erase(0, raw.size);
  if (piece.bytes.empty()) group_.pop_front();
  return sample;
}

template <class Content>
Result<std::unique_ptr<ImportFeed>> make_log_feed(std::unique_ptr<LogReader> log, const ImportPlan::Sonic& sonic) {
  auto feed = std::make_unique<LogFeed>(std::move(log), std::make_unique<Content>(sonic), sonic.start_offset, sonic.path);
  if (auto surveyed = feed->survey(sonic.file.rate_hz); !surveyed) return surveyed.error();
  return std::unique_ptr<ImportFeed>(std::move(feed));
}

}  // namespace

Result<std::unique_ptr<ImportFeed>> make_trisonica_feed(std::unique_ptr<LogReader> log, const ImportPlan::Sonic& sonic) {
  return make_log_feed<TriSonicaContent>(std::move(log), sonic);
}

Result<std::unique_ptr<ImportFeed>> make_nmea_feed(std::unique_ptr<LogReader> log, const ImportPlan::Sonic& sonic) {
  return make_log_feed<NmeaContent>(std::move(log), sonic);
}

}  // namespace roseau::recorder
