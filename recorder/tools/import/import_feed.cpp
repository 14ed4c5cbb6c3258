#include "recorder/tools/import/import_feed.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

namespace roseau::recorder {

namespace {

using camera::VideoFile;

Result<std::string> read_text(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return Error{ErrorCode::not_found, path + " does not exist: check its path"};
  if (std::filesystem::is_directory(path, error))
    return Error{ErrorCode::invalid_argument, path + " is a folder: name a file in it"};
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) return Error{ErrorCode::io, path + " cannot be read: check that you may"};
  return std::move(text).str();
}

// A record that lies in memory: anemometer or displacement. `Record` has samples, times, begin, remarks and invalid_samples.
template <class Record>
class SeriesFeed : public ImportFeed {
 public:
  SeriesFeed(Record record, StreamInfo info, std::string path, Duration start_offset)
      : record_(std::move(record)), info_(std::move(info)), path_(std::move(path)), start_offset_(start_offset) {}

  std::optional<Duration> begin() const override { return record_.begin; }
  Duration start_offset() const override { return start_offset_; }
  Result<void> start(HostTime start, StreamTable& streams) override {
    start_ = start;
    stream_ = streams.add(info_);
    return {};
  }
  Result<std::optional<HostTime>> next_time() override {
    if (next_ == record_.samples.size()) return std::optional<HostTime>();
    return std::optional(start_ + record_.times.since_first[next_]);
  }
  Sample take() override {
    Sample sample;
    const auto& payload = record_.samples[next_];
    sample.header.stream = stream_;
    sample.header.status = payload.valid ? kStatusOk : kStatusIncomplete;
    sample.header.sequence = static_cast<std::uint32_t>(next_);
    sample.header.arrival_time = start_ + record_.times.since_first[next_];
    sample.header.sample_time = sample.header.arrival_time;
    sample.payload = payload;
    ++next_;
    return sample;
  }
  std::uint64_t expected_samples() const override { return record_.samples.size(); }
  ImportReport::Stream describe() const override {
    return {.topic = info_.topic,
            .path = path_,
            .invalid_samples = record_.invalid_samples,
            .rate_hz = record_.times.rate_hz,
            .remarks = record_.remarks};
  }

 private:
  Record record_;
  StreamInfo info_;
  std::string path_;
  Duration start_offset_;
  HostTime start_;
  StreamId stream_ = 0;
  std::size_t next_ = 0;
};

class VideoFeed : public ImportFeed, private SampleSink {
 public:
  explicit VideoFeed(ImportPlan::Video video) : video_(std::move(video)) {}

  Duration start_offset() const override { return video_.start_offset; }
  Result<void> start(HostTime start, StreamTable& streams) override {
    const auto slash = video_.topic.find('/', 1);
    auto file = camera::make_video_file({.name = video_.topic.substr(1, slash == std::string::npos ? slash : slash - 1),
                                         .topic = video_.topic,
                                         .path = video_.path,
                                         .format = video_.format,
                                         .rate_hz = video_.rate_hz,
                                         .start = start});
    if (!file) return file.error();
    file_ = std::move(*file);
    return file_->open(streams);
  }
  Result<std::optional<HostTime>> next_time() override {
    while (!pending_) {
      // Idle: the sink still holds every frame. It gives them back as it writes them.
      const auto status = file_->read(*this, std::chrono::milliseconds{10});
      if (!status) return status.error();
      if (*status == ReadStatus::finished) return std::optional<HostTime>();
    }
    return std::optional(pending_->header.arrival_time);
  }
  Sample take() override {
    Sample sample = std::move(*pending_);
    pending_.reset();
    return sample;
  }
  std::uint64_t expected_samples() const override { return file_->info().announced_frames; }
  ImportReport::Stream describe() const override {
    ImportReport::Stream stream{.topic = video_.topic, .path = video_.path, .rate_hz = file_->info().rate_hz};
    if (!file_->info().warning.empty()) stream.remarks.push_back(file_->info().warning);
    return stream;
  }

 private:
  bool receive(Sample sample) override {
    pending_ = std::move(sample);
    return true;
  }

  ImportPlan::Video video_;
  std::unique_ptr<VideoFile> file_;
  std::optional<Sample> pending_;
};

}  // namespace

Result<std::unique_ptr<ImportFeed>> make_feed(const ImportPlan::Video& video) {
  return std::unique_ptr<ImportFeed>(std::make_unique<VideoFeed>(video));
}

Result<std::unique_ptr<ImportFeed>> make_feed(const ImportPlan::Sonic& sonic) {
  const auto text = read_text(sonic.path);
  if (!text) return text.error();
  auto record = parse_sonic_file(*text, sonic.path, sonic.file);
  if (!record) return record.error();
  StreamInfo info{.topic = "/" + sonic.name + "/wind",
                  .kind = std::string(to_string(SampleKind::wind)),
                  .role = StreamRole::raw,
                  .device = sonic.name,
                  .metadata = {{"axes", std::string(to_string(sonic.axes))},
                               {"north_offset_deg", fmt::format("{}", sonic.north_offset_deg)},
                               {"rate_hz", fmt::format("{}", record->times.rate_hz)},
                               {"delay_s", "0"},
                               {"link", "file " + sonic.path}}};
  if (!sonic.model.empty()) info.metadata["model"] = sonic.model;
  return std::unique_ptr<ImportFeed>(
      std::make_unique<SeriesFeed<SonicRecord>>(std::move(*record), std::move(info), sonic.path, sonic.start_offset));
}

Result<std::unique_ptr<ImportFeed>> make_feed(const ImportPlan::DisplacementSeries& displacement) {
  const auto text = read_text(displacement.path);
  if (!text) return text.error();
  auto record = parse_displacement_file(*text, displacement.path, displacement.file);
  if (!record) return record.error();
  const std::string name = displacement.name.empty() ? series_name(displacement.path) : displacement.name;
  StreamInfo info{.topic = "/displacement/" + name,
                  .kind = std::string(to_string(SampleKind::displacement)),
                  .role = StreamRole::raw,
                  .device = name,
                  .metadata = {{"unit", std::string(to_string(displacement.file.unit))},
                               {"rate_hz", fmt::format("{}", record->times.rate_hz)},
                               {"link", "file " + displacement.path}}};
  return std::unique_ptr<ImportFeed>(std::make_unique<SeriesFeed<DisplacementRecord>>(
      std::move(*record), std::move(info), displacement.path, displacement.start_offset));
}

}  // namespace roseau::recorder
