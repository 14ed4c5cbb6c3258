#include "drivers/wire/gill_decoder.h"

#include <utility>

namespace roseau::wire {

void GillDecoder::decode(const Sample& raw, SampleSink& sink) {
  const auto& bytes = std::get<RawBytes>(raw.payload);
  framer_.push(bytes.bytes(), raw.header.arrival_time, bytes.byte_time);
  // A longer message was split into full pieces; only a piece that is not full can be its end.
  const bool message_ends = options_.keeps_messages_apart && bytes.size < RawBytes::kCapacity;
  while (const auto record = framer_.next(message_ends)) hand_on(*record, sink);
  counters_ = framer_.counters();
  counters_.records = records_;
  counters_.bad_records += unreadable_records_;
  counters_.text_lines += foreign_records_;
}

void GillDecoder::hand_on(const GillRecord& record, SampleSink& sink) {
  const bool is_other_node = options_.node != 0 && !record.is_nmea && record.body.front() != options_.node;
  if (is_other_node || options_.dialect.is_foreign(record)) {
    ++foreign_records_;
    return;
  }
  auto wind = options_.dialect.parse(record);
  if (!wind) {
    ++unreadable_records_;
    return;
  }
  Sample sample;
  sample.header.stream = options_.stream;
  sample.header.status = wind->valid ? kStatusOk : kStatusDeviceError;
  sample.header.sequence = static_cast<std::uint32_t>(records_++);
  sample.header.arrival_time = record.first_byte_time;
  sample.header.sample_time = record.first_byte_time - options_.delay;
  sample.payload = *wind;
  sink.receive(std::move(sample));
}

}  // namespace roseau::wire
