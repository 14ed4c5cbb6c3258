#include <fmt/format.h>

#include <vector>

#include "core/image_coding/png_encoder.h"
#include "recorder/tools/export/export_session.h"
#include "recorder/tools/export/output_file.h"
#include "recorder/tools/export/session_part.h"

namespace roseau::recorder {

namespace {

constexpr const char* kIndexHead = "file,utc,time_s,arrival_s,sequence,status,width_px,height_px,exposure_s\r\n";

/// One camera's pictures and their index.
class FrameFiles {
 public:
  static Result<FrameFiles> create(const std::filesystem::path& directory, const std::string& topic) {
    const std::string name = file_name_of(topic);
    auto index = OutputFile::create(directory / (name + ".csv"));
    if (!index) return index.error();
    if (auto written = index->write(kIndexHead); !written) return written.error();
    return FrameFiles(directory, name, topic, std::move(*index));
  }

  Result<void> add(const SessionPart& part, const schema::FrameView& view) {
    const auto picture = coded(view);
    if (!picture) return picture.error();
    const std::string extension = view.storage == ImageStorage::jpeg ? "jpg" : "png";
    const std::string file_name = fmt::format("{}_{:08}.{}", name_, count_++, extension);
    auto file = OutputFile::create(directory_ / file_name);
    if (!file) return file.error();
    Result<void> done = file->write(*picture);
    if (done) done = file->close();
    if (!done) return done;
    made_.emplace_back(directory_ / file_name);
    const SampleHeader& header = view.header;
    return index_.write(fmt::format("{},{},{:.9f},{:.9f},{},{},{},{},{:.9f}\r\n", csv_field(file_name),
                                    part.utc(header.sample_time), part.seconds(header.sample_time),
                                    part.seconds(header.arrival_time), header.sequence, header.status, view.width, view.height,
                                    to_seconds(view.exposure_duration)));
  }

  Result<ExportReport::Stream> close() {
    if (auto closed = index_.close(); !closed) return closed.error();
    for (auto& file : made_) file.keep();
    return ExportReport::Stream{.topic = topic_, .path = index_.path(), .rows = count_};
  }

 private:
  FrameFiles(std::filesystem::path directory, std::string name, std::string topic, OutputFile index)
      : directory_(std::move(directory)), name_(std::move(name)), topic_(std::move(topic)), index_(std::move(index)) {}

  /// As it is stored, if that is a file already; else made one.
  Result<std::span<const std::byte>> coded(const schema::FrameView& view) {
    if (view.storage != ImageStorage::raw) return view.coded;
    buffer_.resize(image::PngEncoder::buffer_bytes(view.width, view.height, view.format));
    const auto size = encoder_.encode({view.pixels, view.width, view.height, view.stride, view.format}, buffer_);
    if (!size) return size.error().with_context(topic_);
    return std::span<const std::byte>(buffer_).first(*size);
  }

  std::filesystem::path directory_;
  std::string name_;
  std::string topic_;
  OutputFile index_;
  std::vector<RemoveUnlessKept> made_;
  std::uint64_t count_ = 0;
  image::PngEncoder encoder_;
  std::vector<std::byte> buffer_;
};

}  // namespace

Result<ExportReport> export_frames(const std::filesystem::path& session, const SelectionOptions& options,
                                   const std::filesystem::path& directory, const ToolProgress& progress) {
  auto part = SessionPart::open(session, options);
  if (!part) return part.error();
  part->keep([](const SessionPart::Stream& stream) { return stream.kind == SampleKind::frame; });
  if (part->streams().empty()) {
    return Error{ErrorCode::invalid_argument, session.string() + " holds no pictures under the topics that were asked for"};
  }
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) return Error{ErrorCode::io, fmt::format("cannot make {}: {}", directory.string(), error.message())};
  std::map<std::uint16_t, FrameFiles> cameras;
  for (const auto& [id, stream] : part->streams()) {
    auto camera = FrameFiles::create(directory, stream.info.topic);
    if (!camera) return camera.error();
    cameras.emplace(id, std::move(*camera));
  }
  const auto done = part->for_each_frame(
      [&](std::uint16_t id, const schema::FrameView& view) { return cameras.at(id).add(*part, view); }, progress);
  if (!done) return done.error();
  for (auto& [id, camera] : cameras) {
    auto closed = camera.close();
    if (!closed) return closed.error();
    part->report().streams.push_back(std::move(*closed));
  }
  return std::move(part->report());
}

}  // namespace roseau::recorder
