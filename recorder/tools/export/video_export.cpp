#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/image_coding/image_decoder.h"
#include "drivers/camera/file/video_writer.h"
#include "recorder/tools/export/export_session.h"
#include "recorder/tools/export/output_file.h"
#include "recorder/tools/export/session_part.h"

namespace roseau::recorder {

namespace {

constexpr double kUsualRate_hz = 25;
constexpr const char* kTimesHead = "frame,utc,time_s,arrival_s,sequence,status,exposure_s\r\n";

/// The camera's rate over the part, which becomes the video's: from the file's own times, by the middle interval.
Result<double> usual_rate(SessionPart& part) {
  std::vector<double> intervals_s;
  std::optional<HostTime> last;
  constexpr std::size_t kEnough = 200;
  auto seen = part.for_each_frame(
      [&](std::uint16_t, const schema::FrameView& view) -> Result<void> {
        if (last) intervals_s.push_back(to_seconds(view.header.sample_time - *last));
        last = view.header.sample_time;
        return {};
      },
      [&intervals_s](double) { return intervals_s.size() < kEnough; });
  if (!seen) return seen.error();
  part.report().stopped = false;
  part.report().damage = part.reader().index().damage;
  if (intervals_s.empty()) return kUsualRate_hz;
  const auto middle = intervals_s.begin() + static_cast<std::ptrdiff_t>(intervals_s.size() / 2);
  std::ranges::nth_element(intervals_s, middle);
  if (!(*middle > 0)) return kUsualRate_hz;
  // Containers hold a rate as a fraction of small numbers.
  return std::round(1000 / *middle) / 1000;
}

class VideoExport {
 public:
  VideoExport(SessionPart& part, std::filesystem::path path, double rate_hz, OutputFile times)
      : part_(part), path_(std::move(path)), rate_hz_(rate_hz), times_(std::move(times)) {}

  Result<void> add(const schema::FrameView& view) {
    if (writer_ == nullptr) {
      if (auto opened = open(view); !opened) return opened;
    }
    if (view.width != width_ || view.height != height_) {
      return Error{ErrorCode::unsupported, fmt::format("the picture size changes from {}x{} to {}x{}: export the parts one by "
                                                       "one with --from and --to",
                                                       width_, height_, view.width, view.height)};
    }
    if (auto written = write_pixels(view); !written) return written;
    const SampleHeader& header = view.header;
    if (last_ && to_seconds(header.sample_time - *last_) * rate_hz_ > 1.5) ++holes_;
    last_ = header.sample_time;
    return times_.write(fmt::format("{},{},{:.9f},{:.9f},{},{},{:.9f}\r\n", frames_++, part_.utc(header.sample_time),
                                    part_.seconds(header.sample_time), part_.seconds(header.arrival_time), header.sequence,
                                    header.status, to_seconds(view.exposure_duration)));
  }

  Result<ExportReport::Stream> close(const std::string& topic) {
    if (writer_ == nullptr) return Error{ErrorCode::invalid_argument, "there is no picture in the part that was asked for"};
    auto done = writer_->close();
    if (done) done = times_.close();
    if (!done) return done.error();
    removal_->keep();
    std::string remark = fmt::format("plays at {} frames/s; the true times are in {}", rate_hz_, times_.path().string());
    if (holes_ > 0) remark += fmt::format("; {} gaps are not seen in the video", holes_);
    return ExportReport::Stream{.topic = topic, .path = path_, .rows = frames_, .remark = remark};
  }

 private:
  Result<void> open(const schema::FrameView& view) {
    width_ = view.width;
    height_ = view.height;
    auto writer = camera::make_video_writer({.path = path_.string(), .rate_hz = rate_hz_, .width = width_, .height = height_});
    if (!writer) return writer.error();
    if (auto opened = (*writer)->open(); !opened) return opened;
    removal_.emplace(path_);
    writer_ = std::move(*writer);
    return {};
  }

  Result<void> write_pixels(const schema::FrameView& view) {
    if (view.storage == ImageStorage::raw) return writer_->write(view.pixels, view.stride, view.format);
    buffer_.resize(view.pixel_bytes());
    const auto decoded = decoder_.decode(view.coded, buffer_, view.format);
    if (!decoded) return decoded.error();
    return writer_->write(buffer_, view.stride, view.format);
  }

  SessionPart& part_;
  std::filesystem::path path_;
  double rate_hz_;
  OutputFile times_;
  std::optional<RemoveUnlessKept> removal_;  // outlives the writer, which has the file open
  std::unique_ptr<camera::VideoWriter> writer_;
  std::uint32_t width_ = 0;
  std::uint32_t height_ = 0;
  std::uint64_t frames_ = 0;
  std::uint64_t holes_ = 0;
  std::optional<HostTime> last_;
  image::ImageDecoder decoder_;
  std::vector<std::byte> buffer_;
};

}  // namespace

Result<ExportReport> export_video(const std::filesystem::path& session, const SelectionOptions& options,
                                  const std::filesystem::path& file, const ToolProgress& progress) {
  auto part = SessionPart::open(session, options);
  if (!part) return part.error();
  part->keep([](const SessionPart::Stream& stream) { return stream.kind == SampleKind::frame; });
  if (part->streams().size() != 1) {
    std::string topics;
    for (const auto& [id, stream] : part->streams()) topics += (topics.empty() ? "" : ", ") + stream.info.topic;
    return Error{ErrorCode::invalid_argument, topics.empty() ? session.string() + " holds no pictures"
                                                             : "a video shows one camera: choose with --topic among " + topics};
  }
  if (auto absent = require_absent(file); !absent) return absent.error();
  const auto rate_hz = usual_rate(*part);
  if (!rate_hz) return rate_hz.error();
  auto times_path = file;
  times_path += ".csv";
  auto times = OutputFile::create(times_path);
  if (!times) return times.error();
  if (auto written = times->write(kTimesHead); !written) return written.error();
  VideoExport video(*part, file, *rate_hz, std::move(*times));
  const auto done =
      part->for_each_frame([&](std::uint16_t, const schema::FrameView& view) { return video.add(view); }, progress);
  if (!done) return done.error();
  auto closed = video.close(part->streams().begin()->second.info.topic);
  if (!closed) return closed.error();
  part->report().streams.push_back(std::move(*closed));
  return std::move(part->report());
}

}  // namespace roseau::recorder
