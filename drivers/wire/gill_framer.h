// Cuts Gill's text records out of a stream of bytes:
//
//   STX body ETX HH CR LF      HH = XOR of the body in hexadecimal; a record ends with HH, its terminator may be CR alone
//   $ body * HH CR LF          NMEA
//   body HH CR LF              a line whose STX and ETX were left out or lost, if its checksum fits
//   body                       a whole message by itself (UDP), with or without a checksum
//
// Whatever else comes (power-up banner, echo of commands, noise, halves of records) is skipped and counted. After a damaged
// record the search goes on one byte behind its beginning, so that a good record inside or right behind is not lost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/decoder.h"
#include "core/time.h"
#include "drivers/wire/timed_bytes.h"

namespace roseau::wire {

struct GillRecord {
  std::string_view body;  // valid until the framer is used again
  bool is_nmea = false;
  HostTime first_byte_time;
};

class GillFramer {
 public:
  /// Longer than any record (a WindMaster's longest has 105 bytes). What is longer is no record: this bounds the memory.
  static constexpr std::size_t kLongestRecord = 160;

  /// TimedBytes::push. next() must have been called until it had no more.
  void push(std::span<const std::byte> bytes, HostTime first_byte_time, Duration byte_time) {
    bytes_.push(bytes, first_byte_time, byte_time);
  }

  /// The next complete record with the right checksum; nothing until more bytes come. `message_ends`: the bytes pushed so
  /// far end a message, so that nothing still open will be continued.
  std::optional<GillRecord> next(bool message_ends);

  void reset();

  /// bad_records: the damaged ones; the decoder adds those whose fields make no sense.
  const DecoderCounters& counters() const { return counters_; }

 private:
  enum class Step : std::uint8_t { found_record, went_on, needs_more };

  std::string_view pending() const { return bytes_.text(); }
  Step step(bool message_ends, GillRecord& record);
  Step match_delimited(bool is_nmea, bool message_ends, GillRecord& record);
  Step match_line(bool message_ends, GillRecord& record);
  Step finish_line(std::size_t length, bool message_ends, GillRecord& record);
  Step give_up_delimited(bool is_nmea, std::size_t seen);
  Step skip_inside_line();
  Step take(std::string_view body, bool is_nmea, std::size_t length, GillRecord& record);
  Step skip(std::size_t length, bool then_at_line_start);
  void drop_terminators();

  TimedBytes<kLongestRecord + 4> bytes_;
  bool at_line_start_ = true;
  bool behind_record_ = false;
  DecoderCounters counters_;
};

}  // namespace roseau::wire
