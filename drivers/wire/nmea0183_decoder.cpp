#include <fmt/format.h>

#include <algorithm>

#include "core/wind_geometry.h"
#include "drivers/wire/metadata.h"
#include "drivers/wire/nmea0183.h"

namespace roseau::wire {

namespace {
constexpr std::string_view kOptional = "optional";
constexpr std::size_t kChecksumDigits = 2;

bool is_printable(char c) { return c >= ' ' && c <= '~'; }
bool is_terminator(char c) { return c == '\r' || c == '\n'; }
}  // namespace

StreamInfo raw_stream(const std::string& device, const NmeaOptions& options, const std::string& link) {
  return {.topic = "/" + device + std::string(kRawSuffix),
          .kind = std::string(to_string(SampleKind::raw_bytes)),
          .role = StreamRole::raw,
          .device = device,
          .metadata = {{"model", std::string(kNmeaModel)},
                       {"axes", std::string(to_string(WindAxes::gill_spar))},
                       {"north_offset_deg", fmt::format("{}", options.north_offset_deg)},
                       {"rate_hz", fmt::format("{}", options.rate_hz)},
                       {"delay_s", fmt::format("{}", options.delay_s)},
                       {"sentence", std::string(to_string(options.source))},
                       {"checksum", std::string(options.requires_checksum ? "required" : kOptional)},
                       {"link", link}}};
}

std::unique_ptr<Decoder> make_nmea_decoder(const StreamInfo& raw, StreamTable& streams) {
  if (metadata_value(raw, "model") != kNmeaModel) return nullptr;
  const auto source = nmea_wind_source_from_string(metadata_value(raw, "sentence"));
  if (!source) return nullptr;
  return std::make_unique<NmeaDecoder>(
      NmeaDecoder::Options{.stream = streams.add(derived_stream(raw, "wind", SampleKind::wind)),
                           .delay = from_seconds(metadata_number(raw, "delay_s", 0)),
                           .source = *source,
                           .requires_checksum = metadata_value(raw, "checksum") != kOptional});
}

void NmeaDecoder::decode(const Sample& raw, SampleSink& sink) {
  const auto& bytes = std::get<RawBytes>(raw.payload);
  bytes_.push(bytes.bytes(), raw.header.arrival_time, bytes.byte_time);
  while (!bytes_.empty() && step(sink)) {
  }
}

void NmeaDecoder::reset() {
  bytes_.clear();
  is_inside_text_ = false;
}

// What is decided here depends on the bytes alone, never on how they were cut into reads.
bool NmeaDecoder::step(SampleSink& sink) {
  const auto text = bytes_.text();
  if (text.front() != '$') return skip_to_start();
  std::size_t end = 1;
  while (end < text.size() && end < kLongestSentence && is_printable(text[end]) && text[end] != '*' && text[end] != '$') ++end;
  if (end == kLongestSentence) return give_up();
  if (end == text.size()) return false;
  const bool has_checksum = text[end] == '*';
  if (has_checksum && text.size() < end + 1 + kChecksumDigits) return false;
  const std::size_t length = has_checksum ? end + 1 + kChecksumDigits : end;
  const bool ends_well = has_checksum || is_terminator(text[end]);
  const auto body = ends_well ? nmea_body(text.substr(0, length), options_.requires_checksum) : std::nullopt;
  if (!body) return give_up();
  take(*body, sink);
  bytes_.drop(length);
  return true;
}

// Whatever is no sentence: noise, answers in plain text, halves.
bool NmeaDecoder::skip_to_start() {
  const char first = bytes_.text().front();
  if (is_terminator(first)) {
    if (is_inside_text_) ++counters_.text_lines;
    is_inside_text_ = false;
  } else {
    is_inside_text_ = true;
    ++counters_.skipped_bytes;
  }
  bytes_.drop(1);
  return true;
}

bool NmeaDecoder::give_up() {
  ++counters_.bad_records;
  ++counters_.skipped_bytes;
  bytes_.drop(1);
  is_inside_text_ = false;
  return true;
}

void NmeaDecoder::take(std::string_view body, SampleSink& sink) {
  is_inside_text_ = false;
  if (is_foreign_to_nmea_wind(body, options_.source)) {
    ++counters_.text_lines;
    return;
  }
  const auto wind = parse_nmea_wind(body, options_.source);
  if (!wind) {
    ++counters_.bad_records;
    return;
  }
  Sample sample;
  sample.header.stream = options_.stream;
  sample.header.status = wind->valid ? kStatusOk : kStatusDeviceError;
  sample.header.sequence = static_cast<std::uint32_t>(counters_.records++);
  sample.header.arrival_time = bytes_.first_byte_time();
  sample.header.sample_time = sample.header.arrival_time - options_.delay;
  sample.payload = *wind;
  sink.receive(std::move(sample));
}

}  // namespace roseau::wire
