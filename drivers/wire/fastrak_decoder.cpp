#include "drivers/wire/fastrak_decoder.h"

#include <algorithm>
#include <utility>

namespace roseau::wire {

namespace {

// Longer than the answer to S and than any error message.
constexpr std::size_t kLongestAnswer = 200;

bool is_printable(char c) { return c >= ' ' && c <= '~'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

// "21S3F7...", "2 E*ERROR*...": record type, station or space, letter of the command.
bool may_be_answer(std::string_view text) {
  if (text[0] != '2') return false;
  if (text.size() > 1 && text[1] != ' ' && !(text[1] >= '1' && text[1] < '1' + kFastrakStations)) return false;
  return text.size() < 3 || is_letter(text[2]);
}

}  // namespace

void FastrakDecoder::decode(const Sample& raw, SampleSink& sink) {
  const auto& bytes = std::get<RawBytes>(raw.payload);
  bytes_.push(bytes.bytes(), raw.header.arrival_time, bytes.byte_time);
  while (!bytes_.empty() && step(sink) == Step::went_on) {
  }
}

void FastrakDecoder::reset() {
  bytes_.clear();
  in_step_ = false;
}

FastrakDecoder::Step FastrakDecoder::step(SampleSink& sink) {
  const char first = bytes_.text().front();
  if (first == '0') return match_record(sink);
  if (first == '2') return match_answer();
  return skip_byte(false);
}

// What is decided here depends on the bytes alone, never on how they were cut into reads: no more is looked at than a record
// of either form needs.
FastrakDecoder::Step FastrakDecoder::match_record(SampleSink& sink) {
  const auto text = bytes_.text();
  if (text.size() < kFastrakHeaderBytes) return Step::needs_more;
  if (!is_fastrak_header(text)) return skip_byte(false);
  const std::size_t binary_bytes = options_.layout.binary_bytes();
  if (text.size() < binary_bytes) return Step::needs_more;
  if (const auto pose = parse_fastrak_binary(text.substr(0, binary_bytes), options_.layout, unit_)) {
    hand_on(*pose, sink);
    used(binary_bytes);
    return Step::went_on;
  }
  const auto record = text.substr(0, options_.layout.text_bytes());
  if (!may_become_fastrak_text(record, options_.layout)) return skip_byte(true);
  if (record.size() < options_.layout.text_bytes()) return Step::needs_more;
  const auto pose = parse_fastrak_text(record, options_.layout, unit_);
  if (!pose) return skip_byte(true);
  hand_on(*pose, sink);
  used(record.size());
  return Step::went_on;
}

FastrakDecoder::Step FastrakDecoder::match_answer() {
  const auto text = bytes_.text();
  if (!may_be_answer(text)) return skip_byte(false);
  const auto seen = text.substr(0, kLongestAnswer);
  const auto* stop = std::ranges::find_if_not(seen, is_printable);
  const auto length = static_cast<std::size_t>(stop - seen.begin());
  if (length == kLongestAnswer) return skip_byte(false);
  if (length + 2 > text.size() && (length == text.size() || text[length] == '\r')) return Step::needs_more;
  if (text.substr(length, 2) != "\r\n") return skip_byte(false);
  const auto line = text.substr(0, length + 2);
  if (const auto status = parse_fastrak_status(line)) unit_ = status->unit;
  ++counters_.text_lines;
  used(line.size());
  return Step::went_on;
}

FastrakDecoder::Step FastrakDecoder::skip_byte(bool looked_like_a_record) {
  if (in_step_ || looked_like_a_record) ++counters_.bad_records;
  in_step_ = false;
  ++counters_.skipped_bytes;
  bytes_.drop(1);
  return Step::went_on;
}

void FastrakDecoder::used(std::size_t count) {
  bytes_.drop(count);
  in_step_ = true;
}

void FastrakDecoder::hand_on(const StationPose& pose, SampleSink& sink) {
  Station& station = stations_.at(pose.station - 1U);
  if (!station.stream) station.stream = options_.stream_of_station(pose.station);
  Sample sample;
  sample.header.stream = *station.stream;
  sample.header.status = pose.valid ? kStatusOk : kStatusDeviceError;
  sample.header.sequence = station.records++;
  sample.header.arrival_time = bytes_.first_byte_time();
  sample.header.sample_time = sample.header.arrival_time - options_.delay;
  sample.payload = pose;
  ++counters_.records;
  sink.receive(std::move(sample));
}

}  // namespace roseau::wire
