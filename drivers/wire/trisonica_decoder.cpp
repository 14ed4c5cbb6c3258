#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/wind_geometry.h"
#include "drivers/wire/metadata.h"
#include "drivers/wire/trisonica.h"

namespace roseau::wire {

namespace {
bool is_terminator(char c) { return c == '\r' || c == '\n'; }
}  // namespace

StreamInfo raw_stream(const std::string& device, const TriSonicaOptions& options, const std::string& link) {
  StreamInfo raw{.topic = "/" + device + std::string(kRawSuffix),
                 .kind = std::string(to_string(SampleKind::raw_bytes)),
                 .role = StreamRole::raw,
                 .device = device,
                 .metadata = {{"model", std::string(kTriSonicaModel)},
                              {"axes", std::string(to_string(WindAxes::east_north))},
                              {"north_offset_deg", fmt::format("{}", options.north_offset_deg)},
                              {"rate_hz", fmt::format("{}", options.rate_hz)},
                              {"delay_s", fmt::format("{}", options.delay_s)},
                              {"link", link}}};
  if (options.layout) raw.metadata["items"] = options.layout->text();
  return raw;
}

std::unique_ptr<Decoder> make_trisonica_decoder(const StreamInfo& raw, StreamTable& streams) {
  if (metadata_value(raw, "model") != kTriSonicaModel) return nullptr;
  TriSonicaDecoder::Options options;
  options.stream = streams.add(derived_stream(raw, "wind", SampleKind::wind));
  options.delay = from_seconds(metadata_number(raw, "delay_s", 0));
  if (const auto items = metadata_value(raw, "items"); !items.empty()) {
    auto layout = TriSonicaLayout::parse(items);
    if (!layout) return nullptr;
    options.layout = std::move(*layout);
  }
  return std::make_unique<TriSonicaDecoder>(std::move(options));
}

void TriSonicaDecoder::decode(const Sample& raw, SampleSink& sink) {
  const auto& bytes = std::get<RawBytes>(raw.payload);
  bytes_.push(bytes.bytes(), raw.header.arrival_time, bytes.byte_time);
  while (step(sink)) {
  }
}

void TriSonicaDecoder::reset() {
  bytes_.clear();
  candidate_.reset();
  scanned_ = 0;
  is_overlong_ = false;
}

// What is decided here depends on the bytes alone, never on how they were cut into reads.
bool TriSonicaDecoder::step(SampleSink& sink) {
  const auto text = bytes_.text().substr(0, kLongestLine + 1);
  const auto* end = std::find_if(text.begin() + static_cast<std::ptrdiff_t>(scanned_), text.end(), is_terminator);
  scanned_ = static_cast<std::size_t>(end - text.begin());
  if (end != text.end()) {
    take_line(scanned_, sink);
    scanned_ = 0;
    return true;
  }
  if (text.size() <= kLongestLine) return false;
  // Too long for a line, but a whole one may stand at its end.
  is_overlong_ = true;
  skip(1);
  --scanned_;
  return true;
}

void TriSonicaDecoder::take_line(std::size_t length, SampleSink& sink) {
  const auto line = bytes_.text().substr(0, length);
  const bool was_overlong = std::exchange(is_overlong_, false);
  if (!was_overlong && (line.empty() || hand_on(line, sink) || (learn(line) && hand_on(line, sink)))) {
    bytes_.drop(length + 1);
    return;
  }
  const std::string first_tag = layout_ ? layout_->items().front().tag + " " : std::string();
  for (std::size_t i = 1; layout_ && i < length; ++i) {
    i = line.find(first_tag, i);
    if (i == std::string_view::npos) break;
    if (!parse_trisonica(line.substr(i), *layout_)) continue;
    ++counters_.bad_records;
    skip(i);
    hand_on(bytes_.text().substr(0, length - i), sink);
    bytes_.drop(length - i + 1);
    return;
  }
  // While the layout is not known yet, a whole line is no damage.
  const bool is_first = !layout_ && TriSonicaLayout::of_line(line);
  const bool has_numbers = line.find_first_of("0123456789") != std::string_view::npos;
  ++(was_overlong || (has_numbers && !is_first) ? counters_.bad_records : counters_.text_lines);
  skip(length + 1);
}

// False: the line does not have the stream's layout.
bool TriSonicaDecoder::hand_on(std::string_view record, SampleSink& sink) {
  const auto values = layout_ ? parse_trisonica(record, *layout_) : std::nullopt;
  if (!values) return false;
  const auto wind = trisonica_wind(*values, *layout_);
  if (!wind) {
    ++counters_.bad_records;
    return true;
  }
  candidate_.reset();
  Sample sample;
  sample.header.stream = options_.stream;
  sample.header.status = wind->valid ? kStatusOk : kStatusDeviceError;
  sample.header.sequence = static_cast<std::uint32_t>(counters_.records++);
  sample.header.arrival_time = bytes_.first_byte_time();
  sample.header.sample_time = sample.header.arrival_time - options_.delay;
  sample.payload = *wind;
  sink.receive(std::move(sample));
  return true;
}

// True: two lines running had this layout, so that it is now the stream's.
bool TriSonicaDecoder::learn(std::string_view line) {
  auto layout = TriSonicaLayout::of_line(line);
  if (!layout) return false;
  if (candidate_ != layout) {
    candidate_ = std::move(layout);
    return false;
  }
  layout_ = std::move(layout);
  return true;
}

void TriSonicaDecoder::skip(std::size_t count) {
  counters_.skipped_bytes += count;
  bytes_.drop(count);
}

}  // namespace roseau::wire
