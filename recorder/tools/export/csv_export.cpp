#include <fmt/format.h>

#include <cmath>

#include "recorder/tools/export/export_session.h"
#include "recorder/tools/export/output_file.h"
#include "recorder/tools/export/sample_table.h"
#include "recorder/tools/export/session_part.h"

namespace roseau::recorder {

namespace {

std::string text_of(const Field& field) {
  if (const auto* number = std::get_if<double>(&field)) return std::isnan(*number) ? "" : fmt::format("{}", *number);
  if (const auto* integer = std::get_if<std::int64_t>(&field)) return fmt::format("{}", *integer);
  return csv_field(std::get<std::string>(field));
}

/// One topic's file.
class CsvFile {
 public:
  static Result<CsvFile> create(const std::filesystem::path& directory, const SessionPart::Stream& stream,
                                const std::string& name) {
    auto file = OutputFile::create(directory / (name + ".csv"));
    if (!file) return file.error();
    std::string head = "utc,time_s,arrival_s,sequence,status";
    for (const Column& column : columns_of(stream.kind)) head += "," + column.name;
    if (auto written = file->write(head + "\r\n"); !written) return written.error();
    return CsvFile(std::move(*file), stream.info.topic);
  }

  Result<void> add(const SessionPart& part, const Sample& sample) {
    const SampleHeader& header = sample.header;
    const std::string front =
        fmt::format("{},{:.9f},{:.9f},{},{}", part.utc(header.sample_time), part.seconds(header.sample_time),
                    part.seconds(header.arrival_time), header.sequence, header.status);
    for (const auto& row : rows_of(sample)) {
      std::string line = front;
      for (const Field& field : row) line += "," + text_of(field);
      if (auto written = file_.write(line + "\r\n"); !written) return written;
      ++rows_;
    }
    return {};
  }

  Result<void> close() { return file_.close(); }
  ExportReport::Stream report() const { return {.topic = topic_, .path = file_.path(), .rows = rows_}; }

 private:
  CsvFile(OutputFile file, std::string topic) : file_(std::move(file)), topic_(std::move(topic)) {}
  OutputFile file_;
  std::string topic_;
  std::uint64_t rows_ = 0;
};

}  // namespace

Result<ExportReport> export_csv(const std::filesystem::path& session, const SelectionOptions& options,
                                const std::filesystem::path& directory, const ToolProgress& progress) {
  auto part = SessionPart::open(session, options);
  if (!part) return part.error();
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) return Error{ErrorCode::io, fmt::format("cannot make {}: {}", directory.string(), error.message())};
  std::map<std::uint16_t, CsvFile> files;
  std::map<std::string, int> names;
  for (const auto& [id, stream] : part->streams()) {
    if (stream.messages == 0) continue;
    std::string name = file_name_of(stream.info.topic);
    if (const int again = names[name]++; again > 0) name += fmt::format("-{}", again + 1);
    auto file = CsvFile::create(directory, stream, name);
    if (!file) return file.error();
    files.emplace(id, std::move(*file));
  }
  auto done = part->for_each_sample(
      [&](std::uint16_t id, const Sample& sample) {
        const auto file = files.find(id);
        return file == files.end() ? Result<void>{} : file->second.add(*part, sample);
      },
      progress);
  if (!done) return done.error();
  for (auto& [id, file] : files) {
    if (auto closed = file.close(); !closed) return closed.error();
    part->report().streams.push_back(file.report());
  }
  return std::move(part->report());
}

}  // namespace roseau::recorder
