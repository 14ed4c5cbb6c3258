#include "drivers/wire/gill_framer.h"

#include <algorithm>

#include "drivers/wire/fields.h"

namespace roseau::wire {

namespace {

constexpr char kStx = '\x02';
constexpr char kEtx = '\x03';
constexpr std::size_t kChecksumDigits = 2;
constexpr std::size_t kLongestNmea = 82;  // NMEA 0183

bool is_printable(char c) { return c >= ' ' && c <= '~'; }
bool is_terminator(char c) { return c == '\r' || c == '\n'; }

// "Q,...": one letter names the instrument.
bool looks_like_gill(std::string_view body) { return body.size() >= 2 && body[0] >= 'A' && body[0] <= 'Z' && body[1] == ','; }

// "WIMWV,...": two letters of the talker, then the sentence we know.
bool looks_like_wind_sentence(std::string_view body) { return body.size() >= 6 && body.substr(2, 4) == "MWV,"; }

bool checksum_fits(std::string_view body, std::string_view digits) {
  const auto printed = parse_hex_byte(digits);
  return printed && *printed == xor_of(body);
}

// The body of a line that came without STX and ETX. Its checksum, if it has one, is its last field.
std::optional<std::string_view> body_of_line(std::string_view line, bool checksum_required) {
  if (!looks_like_gill(line)) return std::nullopt;
  const auto last_field = line.rfind(',') + 1;
  if (checksum_fits(line.substr(0, last_field), line.substr(last_field))) return line.substr(0, last_field);
  // A message has the network's own checksum. (A wrong one of the instrument's makes a field too many: the parser refuses.)
  if (checksum_required) return std::nullopt;
  return line;
}

}  // namespace

std::optional<GillRecord> GillFramer::next(bool message_ends) {
  GillRecord record;
  while (true) {
    drop_terminators();
    if (bytes_.empty()) break;
    const Step done = step(message_ends, record);
    if (done == Step::found_record) return record;
    if (done == Step::needs_more) return std::nullopt;
  }
  if (message_ends) at_line_start_ = true;
  return std::nullopt;
}

void GillFramer::drop_terminators() {
  while (behind_record_ && !bytes_.empty()) {
    behind_record_ = is_terminator(pending().front());
    if (behind_record_) bytes_.drop(1);
  }
}

GillFramer::Step GillFramer::step(bool message_ends, GillRecord& record) {
  const char first = pending().front();
  if (first == kStx) return match_delimited(false, message_ends, record);
  if (first == '$') return match_delimited(true, message_ends, record);
  if (at_line_start_) return match_line(message_ends, record);
  return skip_inside_line();
}

GillFramer::Step GillFramer::match_delimited(bool is_nmea, bool message_ends, GillRecord& record) {
  const char end_mark = is_nmea ? '*' : kEtx;
  const std::size_t longest = is_nmea ? kLongestNmea : kLongestRecord;
  const auto text = pending();
  for (std::size_t i = 1; i < text.size() && i < longest; ++i) {
    if (text[i] == end_mark) {
      if (text.size() < i + 1 + kChecksumDigits) break;
      const auto body = text.substr(1, i - 1);
      if (!checksum_fits(body, text.substr(i + 1, kChecksumDigits))) return give_up_delimited(is_nmea, i);
      return take(body, is_nmea, i + 1 + kChecksumDigits, record);
    }
    if (!is_printable(text[i]) || text[i] == '$') return give_up_delimited(is_nmea, i);
  }
  if (message_ends || text.size() >= longest + kChecksumDigits)
    return give_up_delimited(is_nmea, std::min(longest, text.size()));
  return Step::needs_more;
}

// Only what was looked at may count: how much more there is depends on how the stream was cut into reads.
GillFramer::Step GillFramer::give_up_delimited(bool is_nmea, std::size_t seen) {
  const auto body = pending().substr(1, seen - 1);
  if (is_nmea ? looks_like_wind_sentence(body) : looks_like_gill(body)) ++counters_.bad_records;
  return skip(1, false);
}

GillFramer::Step GillFramer::match_line(bool message_ends, GillRecord& record) {
  const auto text = pending();
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (is_terminator(c)) return finish_line(i, message_ends, record);
    if (i > 0 && (c == kStx || c == '$')) return skip(i, true);
    if (c == kEtx) {
      if (text.size() < i + 1 + kChecksumDigits) {
        if (!message_ends) return Step::needs_more;
        return skip(text.size(), true);
      }
      const auto body = text.substr(0, i);
      const bool fits = looks_like_gill(body) && checksum_fits(body, text.substr(i + 1, kChecksumDigits));
      return fits ? take(body, false, i + 1 + kChecksumDigits, record) : skip(i + 1, false);
    }
    if (!is_printable(c) || i >= kLongestRecord) return skip(i + 1, false);
  }
  return message_ends ? finish_line(text.size(), message_ends, record) : Step::needs_more;
}

GillFramer::Step GillFramer::finish_line(std::size_t length, bool message_ends, GillRecord& record) {
  const auto line = pending().substr(0, length);
  if (const auto body = body_of_line(line, !message_ends)) return take(*body, false, length, record);
  if (!line.empty()) ++counters_.text_lines;
  return skip(std::min(length + 1, pending().size()), true);
}

GillFramer::Step GillFramer::skip_inside_line() {
  const auto text = pending();
  const auto stop = std::ranges::find_if(text, [](char c) { return c == kStx || c == '$' || is_terminator(c); });
  const auto length = static_cast<std::size_t>(stop - text.begin());
  const bool ends_line = stop != text.end() && is_terminator(*stop);
  return skip(ends_line ? length + 1 : length, ends_line);
}

GillFramer::Step GillFramer::take(std::string_view body, bool is_nmea, std::size_t length, GillRecord& record) {
  record = {.body = body, .is_nmea = is_nmea, .first_byte_time = bytes_.first_byte_time()};
  bytes_.drop(length);
  at_line_start_ = true;
  behind_record_ = true;
  return Step::found_record;
}

GillFramer::Step GillFramer::skip(std::size_t length, bool then_at_line_start) {
  counters_.skipped_bytes += length;
  bytes_.drop(length);
  at_line_start_ = then_at_line_start;
  return Step::went_on;
}

void GillFramer::reset() {
  bytes_.clear();
  at_line_start_ = true;
  behind_record_ = false;
}

}  // namespace roseau::wire
