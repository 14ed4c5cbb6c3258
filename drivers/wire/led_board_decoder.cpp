#include <fmt/format.h>

#include <utility>

#include "drivers/wire/led_board.h"
#include "drivers/wire/metadata.h"

namespace roseau::wire {

namespace {

constexpr std::string_view kModel = "led_board";
constexpr std::string_view kKinds = "TqDBV";
constexpr std::size_t kChecksumDigits = 2;

bool is_printable(char c) { return c >= ' ' && c <= '~'; }
bool is_terminator(char c) { return c == '\r' || c == '\n'; }

}  // namespace

StreamInfo raw_stream(const std::string& device, const LedBoardOptions& options, const std::string& link) {
  return {.topic = "/" + device + std::string(kRawSuffix),
          .kind = std::string(to_string(SampleKind::raw_bytes)),
          .role = StreamRole::raw,
          .device = device,
          .metadata = {{"model", std::string(kModel)}, {"tick_us", fmt::format("{}", options.tick_us)}, {"link", link}}};
}

StreamInfo led_board_stream(const StreamInfo& raw, std::string_view what) {
  return derived_stream(raw, what, SampleKind::led_board_time);
}

std::unique_ptr<Decoder> make_led_board_decoder(const StreamInfo& raw, StreamTable& streams) {
  if (metadata_value(raw, "model") != kModel) return nullptr;
  const double tick_us = metadata_number(raw, "tick_us", kLedBoardTick_us);
  if (!(tick_us >= 1 && tick_us <= 1e6)) return nullptr;
  return std::make_unique<LedBoardDecoder>(
      LedBoardDecoder::Options{.tick_us = static_cast<std::uint32_t>(tick_us),
                               .time_stream = streams.add(led_board_stream(raw, kLedBoardTime)),
                               .edge_stream = streams.add(led_board_stream(raw, kLedBoardEdge)),
                               .probe_stream = streams.add(led_board_stream(raw, kLedBoardProbe))});
}

void LedBoardDecoder::decode(const Sample& raw, SampleSink& sink) {
  const auto& bytes = std::get<RawBytes>(raw.payload);
  bytes_.push(bytes.bytes(), raw.header.arrival_time, bytes.byte_time);
  while (!bytes_.empty() && step(sink) == Step::went_on) {
  }
}

void LedBoardDecoder::reset() { bytes_.clear(); }

// What is decided here depends on the bytes alone, never on how they were cut into reads.
LedBoardDecoder::Step LedBoardDecoder::step(SampleSink& sink) {
  const auto text = bytes_.text();
  if (is_terminator(text[0])) {
    bytes_.drop(1);
    return Step::went_on;
  }
  if (kKinds.find(text[0]) == std::string_view::npos) return skip(1);
  if (text.size() < 2) return Step::needs_more;
  if (text[1] != ',') return skip(1);
  std::size_t star = 2;
  while (star < text.size() && star < kLongestLine && text[star] != '*' && is_printable(text[star])) ++star;
  if (star == text.size()) return Step::needs_more;
  const std::size_t length = star + 1 + kChecksumDigits;
  const bool ends_well = star < kLongestLine && text[star] == '*';
  if (ends_well && text.size() < length) return Step::needs_more;
  const auto message = ends_well ? parse_led_board(text.substr(0, length)) : std::nullopt;
  if (!message) {
    ++counters_.bad_records;
    return skip(1);
  }
  take(*message, sink);
  bytes_.drop(length);
  return Step::went_on;
}

LedBoardDecoder::Step LedBoardDecoder::skip(std::size_t count) {
  counters_.skipped_bytes += count;
  bytes_.drop(count);
  return Step::went_on;
}

void LedBoardDecoder::take(const LedBoardMessage& message, SampleSink& sink) {
  using enum LedBoardTime::Event;
  switch (message.kind) {
    case LedBoardMessage::Kind::latch: {
      const LedBoardTime time{
          .event = latch, .tick = message.tick, .microseconds = message.microseconds, .sequence = message.sequence};
      hand_on(options_.time_stream, time, message.sequence, sink);
      break;
    }
    case LedBoardMessage::Kind::answer: {
      LedBoardTime time = time_at(question_received, message.received_us);
      time.sequence = message.sequence;
      hand_on(options_.probe_stream, time, message.sequence, sink);
      time = time_at(answer_sent, message.sent_us);
      time.sequence = message.sequence;
      hand_on(options_.probe_stream, time, message.sequence, sink);
      break;
    }
    case LedBoardMessage::Kind::edge:
      hand_on(options_.edge_stream, time_at(message.is_rising ? rising_edge : falling_edge, message.received_us), edges_++,
              sink);
      break;
    case LedBoardMessage::Kind::tick_length:
      tick_us_ = message.microseconds;
      ++counters_.text_lines;
      break;
    case LedBoardMessage::Kind::version:
      ++counters_.text_lines;
      break;
  }
}

LedBoardTime LedBoardDecoder::time_at(LedBoardTime::Event event, std::uint64_t board_us) const {
  return {.event = event,
          .tick = static_cast<std::uint32_t>(board_us / tick_us_),
          .microseconds = static_cast<std::uint32_t>(board_us % tick_us_)};
}

// The counter wraps after weeks; an event may be reported after a later one. So the step from the last event counts, whichever
// way it is shorter. A board that started again steps back: the clock model notices.
DeviceTime LedBoardDecoder::unwrap(const LedBoardTime& time) {
  if (unwrapped_tick_) {
    *unwrapped_tick_ += static_cast<std::int32_t>(time.tick - static_cast<std::uint32_t>(*unwrapped_tick_));
  } else {
    unwrapped_tick_ = time.tick;
  }
  return device_time_from_ns((*unwrapped_tick_ * tick_us_ + time.microseconds) * 1000);
}

void LedBoardDecoder::hand_on(StreamId stream, const LedBoardTime& time, std::uint32_t sequence, SampleSink& sink) {
  Sample sample;
  sample.header.stream = stream;
  sample.header.sequence = sequence;
  sample.header.arrival_time = bytes_.first_byte_time();
  sample.header.sample_time = sample.header.arrival_time;
  sample.header.device_time = unwrap(time);
  sample.payload = time;
  ++counters_.records;
  sink.receive(std::move(sample));
}

}  // namespace roseau::wire
