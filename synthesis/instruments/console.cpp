#include "synthesis/instruments/console.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace roseau::synthesis {

namespace {

constexpr char kReset = '\x19';  // ^Y
constexpr char kSave = '\x0B';   // ^K
constexpr std::string_view kWithArguments = "OlHBbRIexvyoAGNqrVtTX";
constexpr std::size_t kLongestCommand = 128;

// Error numbers of the manual's answers.
constexpr int kOutOfRange = -3;
constexpr int kUnknown = -99;

constexpr std::uint64_t kAnswerTime_us = 30;  // from a question's last byte to the answer's first

}  // namespace

FastrakConsole::FastrakConsole(std::shared_ptr<const MagneticTracker> tracker)
    : tracker_(std::move(tracker)),
      layouts_{wire::default_fastrak_layout(), wire::default_fastrak_layout(), wire::default_fastrak_layout(),
               wire::default_fastrak_layout()} {
  set_as_delivered();
}

void FastrakConsole::set_as_delivered() {
  layouts_.fill(wire::default_fastrak_layout());
  for (int station = 1; station <= wire::kFastrakStations; ++station) {
    is_active_.at(static_cast<std::size_t>(station - 1)) = has_station(station);
  }
  is_binary_ = false;
  is_continuous_ = false;
  unit_ = wire::FastrakUnit::inch;
  pending_.clear();
}

std::string FastrakConsole::take(std::string_view received, double time_s) {
  std::string answer;
  for (const char letter : received) {
    if (time_s < silent_until_s_) continue;
    answer += take_letter(letter, time_s);
  }
  return answer;
}

std::string FastrakConsole::take_letter(char letter, double time_s) {
  if (letter == kReset) {
    set_as_delivered();
    silent_until_s_ = time_s + kReset_s;
    return {};
  }
  if (!pending_.empty()) {
    if (letter == '\n') return {};
    if (letter == '\r') return run(std::exchange(pending_, {}));
    pending_ += letter;
    if (pending_.size() > kLongestCommand) return wire::encode_fastrak_error(std::exchange(pending_, {}), kUnknown);
    return {};
  }
  switch (letter) {
    case 'C':
    case 'c':
      is_continuous_ = letter == 'C';
      return {};
    case 'F':
    case 'f':
      is_binary_ = letter == 'f';
      return {};
    case 'U':
    case 'u':
      unit_ = letter == 'U' ? wire::FastrakUnit::inch : wire::FastrakUnit::centimetre;
      return {};
    case 'P':
      return records_of_all(time_s);
    case 'S':
      return status();
    case 'W':
      set_as_delivered();
      return {};
    case kSave:
    case '\r':
    case '\n':
      return {};
    default:
      break;
  }
  if (kWithArguments.find(letter) == std::string_view::npos)
    return wire::encode_fastrak_error(std::string(1, letter), kUnknown);
  pending_ = letter;
  return {};
}

std::string FastrakConsole::run(std::string_view command) {
  if (command.front() == 'O') return set_items(command.substr(1));
  if (command.front() == 'l') return set_station(command.substr(1));
  return {};
}

std::string FastrakConsole::set_items(std::string_view arguments) {
  const int station = arguments.empty() ? 0 : arguments[0] - '0';
  if (!has_station(station) || (arguments.size() > 1 && arguments[1] != ','))
    return wire::encode_fastrak_error("O", kOutOfRange);
  auto& layout = layouts_.at(static_cast<std::size_t>(station - 1));
  if (arguments.size() <= 2) return fmt::format("2{}O{}\r\n", station, layout.text());
  auto parsed = wire::FastrakLayout::parse(arguments.substr(2));
  if (!parsed) return wire::encode_fastrak_error("O", kOutOfRange);
  layout = std::move(*parsed);
  return {};
}

std::string FastrakConsole::set_station(std::string_view arguments) {
  const int station = arguments.empty() ? 0 : arguments[0] - '0';
  const bool asks = arguments.size() == 1;
  const bool sets = arguments.size() == 3 && arguments[1] == ',' && (arguments[2] == '0' || arguments[2] == '1');
  if (!has_station(station) || (!asks && !sets)) return wire::encode_fastrak_error("l", kOutOfRange);
  if (sets) {
    is_active_.at(static_cast<std::size_t>(station - 1)) = arguments[2] == '1';
    return {};
  }
  std::string answer = fmt::format("2{}l", station);
  for (const bool active : is_active_) answer += active ? '1' : '0';
  return answer + "\r\n";
}

std::string FastrakConsole::status() const {
  return wire::encode_fastrak_status({.station = 1,
                                      .is_binary = is_binary_,
                                      .unit = unit_,
                                      .is_continuous = is_continuous_,
                                      .receivers = (1U << static_cast<unsigned>(tracker_->station_count())) - 1U,
                                      .version = "roseau",
                                      .identification = "simulated"});
}

std::string FastrakConsole::record_now(std::uint64_t number) const {
  const auto station = static_cast<std::size_t>(tracker_->station_of(number) - 1);
  if (!is_active_.at(station)) return {};
  return tracker_->record(number, {.layout = layouts_.at(station), .is_binary = is_binary_, .unit = unit_});
}

std::string FastrakConsole::record(std::uint64_t number, double time_s) {
  return is_continuous_ && time_s >= silent_until_s_ ? record_now(number) : std::string();
}

// The last finished measurement of each station.
std::string FastrakConsole::records_of_all(double time_s) const {
  const auto count = static_cast<std::uint64_t>(tracker_->station_count());
  const std::uint64_t next = tracker_->times().first_from(time_s);
  const std::uint64_t first = next < count ? 0 : (next - count) / count * count;
  std::string records;
  for (std::uint64_t i = 0; i < count; ++i) records += record_now(first + i);
  return records;
}

// ---------------------------------------------------------------------------------------------------------------------

std::string LedBoardConsole::take(std::string_view received, double time_s) {
  std::string answers;
  for (const char c : received) {
    if (c == '\r') continue;
    if (c == '\n') {
      answers += answer(std::exchange(pending_, {}), time_s);
    } else if (pending_.size() < kLongestCommand) {
      pending_ += c;
    }
  }
  return answers;
}

std::string LedBoardConsole::answer(std::string_view line, double time_s) const {
  using Kind = wire::LedBoardMessage::Kind;
  const auto command = wire::parse_led_board_command(line);
  if (!command) return {};
  switch (command->kind) {
    case wire::LedBoardCommand::Kind::question: {
      const std::uint64_t received_us = board_->microseconds_at(time_s);
      return wire::encode_led_board({.kind = Kind::answer,
                                     .sequence = command->number,
                                     .received_us = received_us,
                                     .sent_us = received_us + kAnswerTime_us});
    }
    case wire::LedBoardCommand::Kind::set_tick_length:
    case wire::LedBoardCommand::Kind::ask_tick_length:
      return wire::encode_led_board(
          {.kind = Kind::tick_length, .microseconds = static_cast<std::uint32_t>(std::lround(board_->tick_s() * 1e6))});
    case wire::LedBoardCommand::Kind::version:
      return wire::encode_led_board({.kind = Kind::version, .text = "roseau simulated LED board"});
  }
  return {};
}

}  // namespace roseau::synthesis
