#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "drivers/wire/fastrak_decoder.h"
#include "drivers/wire/magnetic_tracker.h"
#include "recorder/tools/import/log_feed.h"

namespace roseau::recorder {

namespace {

// Counts a tracker's records by station; keeps none.
class StationCounter : public SampleSink {
 public:
  bool receive(Sample sample) override {
    ++records_[std::get<StationPose>(sample.payload).station];
    return true;
  }
  std::uint64_t records() const {
    std::uint64_t sum = 0;
    for (const auto& [station, count] : records_) sum += count;
    return sum;
  }
  std::vector<int> stations() const {
    std::vector<int> stations;
    for (const auto& [station, count] : records_) stations.push_back(station);
    return stations;
  }

 private:
  std::map<int, std::uint64_t> records_;
};

RawBytes to_raw(std::string_view bytes) {
  RawBytes raw;
  raw.size = static_cast<std::uint16_t>(bytes.size());
  std::ranges::transform(bytes, raw.storage.begin(), [](char c) { return static_cast<std::byte>(c); });
  return raw;
}

class FastrakFeed : public ImportFeed {
 public:
  FastrakFeed(FileReader file, const ImportPlan::Tracker& tracker) : file_(std::move(file)), tracker_(tracker) {}

  Result<void> survey();

  Duration start_offset() const override { return tracker_.start_offset; }
  Result<void> start(HostTime start, StreamTable& streams) override {
    start_ = start;
    stream_ = streams.add(info_);
    return {};
  }
  Result<std::optional<HostTime>> next_time() override {
    const auto ahead = file_.peek(1);
    if (!ahead) return ahead.error();
    if (ahead->empty()) return std::optional<HostTime>();
    // Read now, because take() cannot fail.
    if (auto filled = file_.peek(RawBytes::kCapacity); !filled) return filled.error();
    return std::optional(start_ + Duration{std::llround(byte_ns_ * static_cast<double>(file_.position()))});
  }
  Sample take() override {
    Sample sample;
    sample.header.stream = stream_;
    sample.header.sequence = samples_++;
    sample.header.arrival_time = start_ + Duration{std::llround(byte_ns_ * static_cast<double>(file_.position()))};
    sample.header.sample_time = sample.header.arrival_time;
    auto raw = to_raw(file_.take(RawBytes::kCapacity).value());
    raw.byte_time = Duration{std::llround(byte_ns_)};
    sample.payload = raw;
    return sample;
  }
  double share() const override { return file_.share(); }
  std::vector<ImportReport::Stream> describe() const override {
    return {{.topic = info_.topic, .path = tracker_.path, .rate_hz = rate_hz_, .remarks = remarks_}};
  }

 private:
  Result<StationCounter> count(const wire::FastrakLayout& layout, std::uint64_t& bad);

  FileReader file_;
  const ImportPlan::Tracker tracker_;
  StreamInfo info_;
  double rate_hz_ = 0;
  double byte_ns_ = 0;
  std::vector<std::string> remarks_;
  HostTime start_;
  StreamId stream_ = 0;
  std::uint32_t samples_ = 0;
};

Result<StationCounter> FastrakFeed::count(const wire::FastrakLayout& layout, std::uint64_t& bad) {
  if (auto rewound = file_.rewind(); !rewound) return rewound.error();
  wire::FastrakDecoder decoder({.layout = layout, .stream_of_station = [](int) { return StreamId{0}; }});
  StationCounter counter;
  while (true) {
    const auto bytes = file_.take(RawBytes::kCapacity);
    if (!bytes) return bytes.error();
    if (bytes->empty()) break;
    Sample sample;
    sample.payload = to_raw(*bytes);
    decoder.decode(sample, counter);
  }
  bad = decoder.counters().bad_records;
  return counter;
}

Result<void> FastrakFeed::survey() {
  StationCounter best;
  auto layout = wire::default_fastrak_layout();
  for (const auto& candidate : {wire::default_fastrak_layout(), wire::quaternion_fastrak_layout()}) {
    std::uint64_t bad = 0;
    auto counted = count(candidate, bad);
    if (!counted) return counted.error();
    if (counted->records() <= best.records()) continue;
    best = std::move(*counted);
    layout = candidate;
  }
  if (best.records() == 0) {
    return Error{ErrorCode::corrupt, tracker_.path +
                                         ": no record of a FASTRAK, neither as text nor binary, with items 2,4,1 or "
                                         "2,11,0"};
  }
  const auto stations = best.stations();
  if (tracker_.file.unit == TrackerUnit::metre)
    return Error{ErrorCode::invalid_argument, tracker_.path + ": a FASTRAK counts in inch or cm, never in metres"};
  wire::MagneticTrackerOptions options{
      .stations = stations,
      .layout = layout,
      .unit = tracker_.file.unit == TrackerUnit::centimetre ? wire::FastrakUnit::centimetre : wire::FastrakUnit::inch};
  info_ = wire::raw_stream(tracker_.name, options, "file " + tracker_.path);
  rate_hz_ = tracker_.file.rate_hz.value_or(options.rate_hz());
  if (!(rate_hz_ > 0))
    return Error{ErrorCode::invalid_argument, fmt::format("{}: a rate of {} Hz makes no sense", tracker_.path, rate_hz_)};
  info_.metadata["rate_hz"] = fmt::format("{}", rate_hz_);
  const double seconds = static_cast<double>(best.records()) / (rate_hz_ * static_cast<double>(stations.size()));
  byte_ns_ = seconds * 1e9 / static_cast<double>(std::max<std::uint64_t>(1, file_.size()));
  remarks_ = {fmt::format("records hold {}; stations {}", layout.text(), fmt::join(stations, ", ")),
              fmt::format("lengths taken as {}, until the tracker itself says so", wire::to_string(options.unit)),
              fmt::format("no times in the file: its bytes are spread evenly, {} records per station and second", rate_hz_)};
  return file_.rewind();
}

}  // namespace

Result<std::unique_ptr<ImportFeed>> make_fastrak_feed(FileReader file, const ImportPlan::Tracker& tracker) {
  auto feed = std::make_unique<FastrakFeed>(std::move(file), tracker);
  if (auto surveyed = feed->survey(); !surveyed) return surveyed.error();
  return std::unique_ptr<ImportFeed>(std::move(feed));
}

}  // namespace roseau::recorder
