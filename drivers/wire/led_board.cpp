#include "drivers/wire/led_board.h"

#include <fmt/format.h>

#include <charconv>
#include <vector>

#include "drivers/wire/fields.h"

namespace roseau::wire {

namespace {

constexpr std::size_t kChecksumLength = 3;  // "*3F"
constexpr std::uint32_t kLongestTick_us = 1'000'000;

template <class Integer>
bool parse_number_into(std::string_view text, Integer& value) {
  // from_chars would take a minus sign for signed types only; these are unsigned.
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

using Fields = std::vector<std::string_view>;

std::optional<LedBoardMessage> parse_latch(const Fields& fields) {
  LedBoardMessage message{.kind = LedBoardMessage::Kind::latch};
  if (fields.size() != 4 || !parse_number_into(fields[1], message.tick) ||
      !parse_number_into(fields[2], message.microseconds) || !parse_number_into(fields[3], message.sequence) ||
      message.microseconds > kLongestTick_us) {
    return std::nullopt;
  }
  return message;
}

std::optional<LedBoardMessage> parse_answer(const Fields& fields) {
  LedBoardMessage message{.kind = LedBoardMessage::Kind::answer};
  if (fields.size() != 4 || !parse_number_into(fields[1], message.sequence) ||
      !parse_number_into(fields[2], message.received_us) || !parse_number_into(fields[3], message.sent_us) ||
      message.sent_us < message.received_us) {
    return std::nullopt;
  }
  return message;
}

std::optional<LedBoardMessage> parse_edge(const Fields& fields) {
  LedBoardMessage message{.kind = LedBoardMessage::Kind::edge};
  if (fields.size() != 3 || !parse_number_into(fields[1], message.received_us) || (fields[2] != "0" && fields[2] != "1")) {
    return std::nullopt;
  }
  message.is_rising = fields[2] == "1";
  return message;
}

std::optional<LedBoardMessage> parse_tick_length(const Fields& fields) {
  LedBoardMessage message{.kind = LedBoardMessage::Kind::tick_length};
  if (fields.size() != 2 || !parse_number_into(fields[1], message.microseconds) || message.microseconds == 0 ||
      message.microseconds > kLongestTick_us) {
    return std::nullopt;
  }
  return message;
}

std::string body_of(const LedBoardMessage& message) {
  switch (message.kind) {
    case LedBoardMessage::Kind::latch:
      return fmt::format("T,{},{},{}", message.tick, message.microseconds, message.sequence);
    case LedBoardMessage::Kind::answer:
      return fmt::format("q,{},{},{}", message.sequence, message.received_us, message.sent_us);
    case LedBoardMessage::Kind::edge:
      return fmt::format("D,{},{}", message.received_us, message.is_rising ? 1 : 0);
    case LedBoardMessage::Kind::tick_length:
      return fmt::format("B,{}", message.microseconds);
    case LedBoardMessage::Kind::version:
      return "V," + message.text;
  }
  return {};
}

}  // namespace

std::optional<LedBoardMessage> parse_led_board(std::string_view line) {
  const auto star = line.rfind('*');
  if (star == std::string_view::npos || star + kChecksumLength != line.size()) return std::nullopt;
  const auto body = line.substr(0, star);
  if (parse_hex_byte(line.substr(star + 1)) != xor_of(body) || body.size() < 2 || body[1] != ',') return std::nullopt;
  const auto fields = split_fields(body);
  switch (body[0]) {
    case 'T':
      return parse_latch(fields);
    case 'q':
      return parse_answer(fields);
    case 'D':
      return parse_edge(fields);
    case 'B':
      return parse_tick_length(fields);
    case 'V':
      return LedBoardMessage{.kind = LedBoardMessage::Kind::version, .text = std::string(body.substr(2))};
    default:
      return std::nullopt;
  }
}

std::string encode_led_board(const LedBoardMessage& message) {
  const std::string body = body_of(message);
  return body + "*" + hex_byte(xor_of(body)) + "\r\n";
}

std::optional<LedBoardCommand> parse_led_board_command(std::string_view line) {
  if (line == "V") return LedBoardCommand{.kind = LedBoardCommand::Kind::version};
  if (line == "B") return LedBoardCommand{.kind = LedBoardCommand::Kind::ask_tick_length};
  if (line.size() < 2 || (line[0] != 'Q' && line[0] != 'B')) return std::nullopt;
  LedBoardCommand command{.kind = line[0] == 'Q' ? LedBoardCommand::Kind::question : LedBoardCommand::Kind::set_tick_length};
  if (!parse_number_into(line.substr(1), command.number)) return std::nullopt;
  const bool is_tick_length = command.kind == LedBoardCommand::Kind::set_tick_length;
  if (is_tick_length && (command.number == 0 || command.number > kLongestTick_us)) return std::nullopt;
  return command;
}

std::string encode_led_board_command(const LedBoardCommand& command) {
  switch (command.kind) {
    case LedBoardCommand::Kind::question:
      return fmt::format("Q{}\n", command.number);
    case LedBoardCommand::Kind::set_tick_length:
      return fmt::format("B{}\n", command.number);
    case LedBoardCommand::Kind::ask_tick_length:
      return "B\n";
    case LedBoardCommand::Kind::version:
      return "V\n";
  }
  return {};
}

}  // namespace roseau::wire
