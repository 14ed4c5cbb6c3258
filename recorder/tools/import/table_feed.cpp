#include "recorder/tools/import/table_feed.h"

#include <fmt/format.h>

#include <map>
#include <utility>

namespace roseau::recorder {

namespace {

class TableFeed : public ImportFeed {
 public:
  TableFeed(std::unique_ptr<TableReader> table, std::unique_ptr<RowMeaning> meaning, std::optional<TimeColumns> time,
            Duration start_offset, std::string path)
      : table_(std::move(table)),
        meaning_(std::move(meaning)),
        time_(std::move(time)),
        start_offset_(start_offset),
        path_(std::move(path)) {}

  Result<void> survey(std::optional<double> rate_hz);

  std::optional<Duration> begin() const override { return grid_.first_stamp; }
  Duration start_offset() const override { return start_offset_; }
  Result<void> start(HostTime start, StreamTable& streams) override;
  Result<std::optional<HostTime>> next_time() override;
  Sample take() override;
  double share() const override { return table_->share(); }
  std::vector<ImportReport::Stream> describe() const override;

 private:
  struct OwnStream {
    StreamInfo info;
    StreamId id = 0;
    std::uint32_t samples = 0;
    std::uint64_t invalid = 0;
    std::uint64_t duplicates = 0;
  };

  Result<void> check_grid(bool rate_was_given);
  Result<std::optional<Duration>> stamp() const;
  Result<void> restart();

  std::unique_ptr<TableReader> table_;
  std::unique_ptr<RowMeaning> meaning_;
  std::optional<TimeColumns> time_;
  Duration start_offset_;
  std::string path_;
  RecordGrid grid_;
  std::vector<OwnStream> streams_;
  std::vector<std::string> remarks_;
  std::optional<RowPlacer> placer_;
  HostTime start_;
  HostTime row_time_;
  std::vector<RowMeaning::Item> items_;  // of the current row
  std::size_t next_item_ = 0;
};

Result<std::optional<Duration>> TableFeed::stamp() const {
  if (!time_) return std::optional<Duration>();
  const auto stamp = row_time(*table_, *time_);
  if (!stamp) return stamp.error();
  return std::optional(*stamp);
}

Result<void> TableFeed::restart() {
  meaning_->restart();
  items_.clear();
  next_item_ = 0;
  return table_->rewind();
}

Result<void> TableFeed::survey(std::optional<double> rate_hz) {
  if (auto restarted = restart(); !restarted) return restarted;
  StampSurvey survey;
  std::map<std::size_t, std::pair<std::uint64_t, std::uint64_t>> flagged;  // invalid, duplicate
  for (auto more = table_->next(); !more || *more; more = table_->next()) {
    if (!more) return more.error();
    const auto time = stamp();
    if (!time) return time.error();
    survey.add(*time);
    items_.clear();
    if (auto read = meaning_->read(*table_, items_); !read) return read;
    for (const auto& item : items_) {
      if ((item.status & (kStatusIncomplete | kStatusDeviceError)) != 0) ++flagged[item.stream].first;
      if ((item.status & kStatusDuplicate) != 0) ++flagged[item.stream].second;
    }
  }
  auto grid = survey.finish(rate_hz, path_);
  if (!grid) return grid.error();
  grid_ = *grid;
  if (!table_->head().description.empty()) remarks_.push_back(table_->head().description);
  const auto meant = meaning_->remarks();
  remarks_.insert(remarks_.end(), meant.begin(), meant.end());
  if (table_->was_cut()) remarks_.emplace_back("the last row is cut short and was left out");
  if (auto checked = check_grid(rate_hz.has_value()); !checked) return checked;
  for (const auto& info : meaning_->streams()) {
    auto& stream = streams_.emplace_back(OwnStream{.info = info});
    stream.info.metadata["rate_hz"] = fmt::format("{}", grid_.rate_hz);
    stream.info.metadata["link"] = "file " + path_;
    stream.invalid = flagged[streams_.size() - 1].first;
    stream.duplicates = flagged[streams_.size() - 1].second;
  }
  return restart();
}

Result<void> TableFeed::check_grid(bool rate_was_given) {
  if (time_)
    remarks_.push_back(
        fmt::format("times: column {}, {}", time_->name,
                    grid_.kind == RecordGrid::Kind::by_rate ? "only the first; then by the rate" : "taken as UTC"));
  if (grid_.kind != RecordGrid::Kind::by_stamp) return {};
  if (auto rewound = table_->rewind(); !rewound) return rewound;
  GridCheck check(grid_);
  for (auto more = table_->next(); !more || *more; more = table_->next()) {
    if (!more) return more.error();
    const auto time = stamp();
    if (!time) return time.error();
    check.add(**time);
  }
  const auto grid = check.finish(rate_was_given, path_);
  if (!grid) return grid.error();
  grid_ = *grid;
  if (grid_.missing_rows > 0) remarks_.push_back(fmt::format("by its times {} rows are missing", grid_.missing_rows));
  if (grid_.kind == RecordGrid::Kind::as_stamped)
    remarks_.emplace_back("its rows are not evenly spaced: each keeps the time of its stamp");
  return {};
}

Result<void> TableFeed::start(HostTime start, StreamTable& streams) {
  start_ = start;
  placer_.emplace(grid_);
  for (auto& stream : streams_) stream.id = streams.add(stream.info);
  return {};
}

Result<std::optional<HostTime>> TableFeed::next_time() {
  while (next_item_ == items_.size()) {
    items_.clear();
    next_item_ = 0;
    const auto more = table_->next();
    if (!more) return more.error();
    if (!*more) return std::optional<HostTime>();
    const auto time = stamp();
    if (!time) return time.error();
    row_time_ = start_ + placer_->next(*time);
    if (auto read = meaning_->read(*table_, items_); !read) return read.error();
  }
  return std::optional(row_time_);
}

Sample TableFeed::take() {
  auto& item = items_[next_item_++];
  auto& stream = streams_[item.stream];
  Sample sample;
  sample.header.stream = stream.id;
  sample.header.status = item.status;
  sample.header.sequence = stream.samples++;
  sample.header.arrival_time = row_time_;
  sample.header.sample_time = row_time_;
  sample.payload = std::move(item.payload);
  return sample;
}

std::vector<ImportReport::Stream> TableFeed::describe() const {
  std::vector<ImportReport::Stream> all;
  for (const auto& stream : streams_) {
    all.push_back({.topic = stream.info.topic,
                   .path = path_,
                   .invalid_samples = stream.invalid,
                   .duplicate_samples = stream.duplicates,
                   .rate_hz = grid_.rate_hz,
                   .remarks = all.empty() ? remarks_ : std::vector<std::string>()});
  }
  return all;
}

}  // namespace

Result<std::unique_ptr<ImportFeed>> make_table_feed(std::unique_ptr<TableReader> table, std::unique_ptr<RowMeaning> meaning,
                                                    std::optional<TimeColumns> time, std::optional<double> rate_hz,
                                                    Duration start_offset, const std::string& path) {
  auto feed = std::make_unique<TableFeed>(std::move(table), std::move(meaning), std::move(time), start_offset, path);
  if (auto surveyed = feed->survey(rate_hz); !surveyed) return surveyed.error();
  return std::unique_ptr<ImportFeed>(std::move(feed));
}

}  // namespace roseau::recorder
