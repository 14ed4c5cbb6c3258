#include "recorder/tools/import/import_feed.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "drivers/camera/file/video_file.h"
#include "recorder/tools/import/displacement_file.h"
#include "recorder/tools/import/find_format.h"
#include "recorder/tools/import/ghg_archive.h"
#include "recorder/tools/import/log_feed.h"
#include "recorder/tools/import/sonic_file.h"
#include "recorder/tools/import/text_table.h"
#include "recorder/tools/import/tob1.h"
#include "recorder/tools/import/tracker_file.h"

namespace roseau::recorder {

namespace {

using camera::VideoFile;

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
    ++frames_;
    return sample;
  }
  double share() const override {
    const auto announced = file_->info().announced_frames;
    return announced == 0 ? 1.0 : std::min(1.0, static_cast<double>(frames_) / static_cast<double>(announced));
  }
  std::vector<ImportReport::Stream> describe() const override {
    ImportReport::Stream stream{.topic = video_.topic, .path = video_.path};
    // Before start() only the topic is known.
    if (file_) stream.rate_hz = file_->info().rate_hz;
    if (file_ && !file_->info().warning.empty()) stream.remarks.push_back(file_->info().warning);
    return {stream};
  }

 private:
  bool receive(Sample sample) override {
    pending_ = std::move(sample);
    return true;
  }

  ImportPlan::Video video_;
  std::unique_ptr<VideoFile> file_;
  std::optional<Sample> pending_;
  std::uint64_t frames_ = 0;
};

Result<FileReader> open_reader(const std::string& path) {
  auto source = open_file(path);
  if (!source) return source.error();
  return FileReader(std::move(*source), path);
}

// The archive, or its .data unpacked.
Result<FileReader> open_ghg(const std::string& path) {
  auto file = open_reader(path);
  if (!file) return file;
  const auto start = file->peek(kZipMark.size());
  if (!start) return start.error();
  if (*start != kZipMark) return file;
  auto member = open_ghg_archive(path);
  if (!member) return member.error();
  return FileReader(std::move(*member), path);
}

Result<std::unique_ptr<TableReader>> open_table(FileReader file, SonicFormat format) {
  if (format == SonicFormat::tob1) {
    auto table = Tob1Table::open(std::move(file));
    if (!table) return table.error();
    if (auto rewound = (*table)->rewind(); !rewound) return rewound.error();
    return std::unique_ptr<TableReader>(std::move(*table));
  }
  const auto kind = format == SonicFormat::toa5  ? TableFormat::toa5
                    : format == SonicFormat::ghg ? TableFormat::ghg
                    : format == SonicFormat::csv ? TableFormat::csv
                                                 : TableFormat::automatic;
  auto table = TextTable::open(std::move(file), kind);
  if (!table) return table.error();
  return std::unique_ptr<TableReader>(std::move(*table));
}

// A text log, a file of blocks, or a folder of such files.
Result<std::unique_ptr<LogReader>> open_trisonica_log(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    std::vector<std::string> paths;
    for (const auto& entry : std::filesystem::directory_iterator(path, error)) {
      if (entry.path().extension() == ".bin") paths.push_back(entry.path().string());
    }
    if (paths.empty())
      return Error{ErrorCode::not_found,
                   path + ": no .bin file in this folder: name the folder that a TriSonica's logger wrote"};
    return open_block_log(std::move(paths));
  }
  auto file = open_reader(path);
  if (!file) return file.error();
  const auto start = file->peek(64);
  if (!start) return start.error();
  if (looks_like_block_log(*start)) return open_block_log({path});
  return open_text_log(std::move(*file));
}

}  // namespace

Result<std::unique_ptr<ImportFeed>> make_feed(const ImportPlan::Video& video) {
  return std::unique_ptr<ImportFeed>(std::make_unique<VideoFeed>(video));
}

Result<std::unique_ptr<ImportFeed>> make_feed(const ImportPlan::Sonic& sonic) {
  auto format = sonic.file.format;
  if (format == SonicFormat::automatic) {
    const auto found = find_sonic_format(sonic.path);
    if (!found) return found.error();
    format = *found;
  }
  if (format == SonicFormat::trisonica) {
    auto log = open_trisonica_log(sonic.path);
    if (!log) return log.error();
    return make_trisonica_feed(std::move(*log), sonic);
  }
  auto file = format == SonicFormat::ghg ? open_ghg(sonic.path) : open_reader(sonic.path);
  if (!file) return file.error();
  if (format == SonicFormat::nmea) return make_nmea_feed(open_text_log(std::move(*file)), sonic);
  auto table = open_table(std::move(*file), format);
  if (!table) return table.error();
  StreamInfo info{.topic = "/" + sonic.name + "/wind",
                  .kind = std::string(to_string(SampleKind::wind)),
                  .role = StreamRole::raw,
                  .device = sonic.name,
                  .metadata = {{"axes", std::string(to_string(sonic.axes))},
                               {"north_offset_deg", fmt::format("{}", sonic.north_offset_deg)},
                               {"delay_s", "0"}}};
  if (!sonic.model.empty()) info.metadata["model"] = sonic.model;
  std::optional<TimeColumns> time;
  auto rows = make_wind_rows(**table, sonic.file, std::move(info), time);
  if (!rows) return rows.error();
  return make_table_feed(std::move(*table), std::move(*rows), time, sonic.file.rate_hz, sonic.start_offset, sonic.path);
}

Result<std::unique_ptr<ImportFeed>> make_feed(const ImportPlan::Tracker& tracker) {
  auto format = tracker.file.format;
  if (format == TrackerFormat::automatic) {
    const auto found = find_tracker_format(tracker.path);
    if (!found) return found.error();
    format = *found;
  }
  auto file = open_reader(tracker.path);
  if (!file) return file.error();
  if (format == TrackerFormat::fastrak) return make_fastrak_feed(std::move(*file), tracker);
  if (format == TrackerFormat::fastrak_matrices) {
    constexpr double kUsualRate_hz = 100;
    auto table = open_matrix_table(std::move(*file));
    if (!table) return table.error();
    return make_table_feed(std::move(*table), make_matrix_rows(tracker.name, tracker.file.unit.value_or(TrackerUnit::metre)),
                           std::nullopt, tracker.file.rate_hz.value_or(kUsualRate_hz), tracker.start_offset, tracker.path);
  }
  auto table = open_table(std::move(*file), SonicFormat::csv);
  if (!table) return table.error();
  std::optional<TimeColumns> time;
  auto rows = make_liberty_rows(**table, tracker.name, tracker.file.unit.value_or(TrackerUnit::inch), time);
  if (!rows) return rows.error();
  // Rows are kept at the times at which the host polled; a grid would move them.
  return make_table_feed(std::move(*table), std::move(*rows), time, tracker.file.rate_hz, tracker.start_offset, tracker.path);
}

Result<std::unique_ptr<ImportFeed>> make_feed(const ImportPlan::DisplacementSeries& displacement) {
  auto file = open_reader(displacement.path);
  if (!file) return file.error();
  auto table = open_table(std::move(*file), SonicFormat::automatic);
  if (!table) return table.error();
  const std::string name = displacement.name.empty() ? series_name(displacement.path) : displacement.name;
  StreamInfo info{.topic = "/displacement/" + name,
                  .kind = std::string(to_string(SampleKind::displacement)),
                  .role = StreamRole::raw,
                  .device = name,
                  .metadata = {{"unit", std::string(to_string(displacement.file.unit))}}};
  std::optional<TimeColumns> time;
  auto rows = make_displacement_rows(**table, displacement.file, std::move(info), time);
  if (!rows) return rows.error();
  return make_table_feed(std::move(*table), std::move(*rows), time, displacement.file.rate_hz, displacement.start_offset,
                         displacement.path);
}

}  // namespace roseau::recorder
