#include <fmt/format.h>

#include <cmath>

#include "recorder/tools/export/export_session.h"
#include "recorder/tools/export/output_file.h"
#include "recorder/tools/export/session_part.h"
#include "recorder/tools/selection/civil_time.h"

namespace roseau::recorder {

namespace {

/// As loggers have it: quoted, without what would end the quotes.
std::string quoted(std::string text) {
  std::erase(text, '"');
  return "\"" + text + "\"";
}

std::string number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "\"NAN\""; }

std::string entry_of(const mcap::StringMap& map, const std::string& key, const std::string& otherwise) {
  const auto found = map.find(key);
  return found == map.end() || found->second.empty() ? otherwise : found->second;
}

std::string head_of(const SessionPart& part, const SessionPart::Stream& stream) {
  std::string head =
      fmt::format("\"TOA5\",{},\"roseau\",\"\",{},{},\"0\",{}\r\n", quoted(entry_of(part.info().other, "name", "roseau")),
                  quoted("roseau " + part.info().program_version), quoted(part.path().filename().string()),
                  quoted(file_name_of(stream.info.topic)));
  head += "\"TIMESTAMP\",\"RECORD\",\"u\",\"v\",\"w\",\"T_SONIC\",\"SOS\",\"diag\"\r\n";
  head += "\"TS\",\"RN\",\"m/s\",\"m/s\",\"m/s\",\"C\",\"m/s\",\"\"\r\n";
  head += "\"\",\"\",\"Smp\",\"Smp\",\"Smp\",\"Smp\",\"Smp\",\"Smp\"\r\n";
  return head;
}

/// Wind that is not usable is not a number: who reads the file need not know what the instrument's status means.
std::string row_of(const SessionPart& part, const Sample& sample, std::uint64_t record) {
  const auto& wind = std::get<WindSample>(sample.payload);
  const auto usable = [&wind](double value) { return number(wind.valid ? value : kNotMeasured); };
  const std::int64_t utc_ns = to_ns(sample.header.sample_time + *part.utc_minus_host_time());
  return fmt::format("\"{}\",{},{},{},{},{},{},{}\r\n", utc_text(utc_ns, 6, ' ', ""), record, usable(wind.u_mps),
                     usable(wind.v_mps), usable(wind.w_mps), number(wind.sonic_temperature_celsius),
                     number(wind.speed_of_sound_mps), wind.device_status);
}

}  // namespace

Result<ExportReport> export_toa5(const std::filesystem::path& session, const SelectionOptions& options,
                                 const std::filesystem::path& file, const ToolProgress& progress) {
  auto part = SessionPart::open(session, options);
  if (!part) return part.error();
  part->keep([](const SessionPart::Stream& stream) { return stream.kind == SampleKind::wind && stream.messages > 0; });
  if (part->streams().size() != 1) {
    std::string topics;
    for (const auto& [id, stream] : part->streams()) topics += (topics.empty() ? "" : ", ") + stream.info.topic;
    return Error{ErrorCode::invalid_argument,
                 topics.empty() ? session.string() + " holds no wind: record or replay it with its sonic anemometer decoded"
                                : "a TOA5 file holds one wind stream: choose with --topic among " + topics};
  }
  if (!part->utc_minus_host_time()) {
    return Error{ErrorCode::invalid_argument,
                 session.string() + " does not know civil time, which TOA5 needs: export it with --csv"};
  }
  const auto& stream = part->streams().begin()->second;
  auto output = OutputFile::create(file);
  if (!output) return output.error();
  auto done = output->write(head_of(*part, stream));
  std::uint64_t rows = 0;
  if (done) {
    done = part->for_each_sample(
        [&](std::uint16_t, const Sample& sample) { return output->write(row_of(*part, sample, rows++)); }, progress);
  }
  if (done) done = output->close();
  if (!done) return done.error();
  part->report().streams.push_back(
      {.topic = stream.info.topic,
       .path = file,
       .rows = rows,
       .remark = fmt::format("times are UTC; u, v, w in the instrument's axes ({}), north offset {} deg",
                             entry_of(stream.info.metadata, "axes", "not said"),
                             entry_of(stream.info.metadata, "north_offset_deg", "not said"))});
  return std::move(part->report());
}

}  // namespace roseau::recorder
