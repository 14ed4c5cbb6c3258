#include "drivers/led_sync/led_board_source.h"

#include <utility>

namespace roseau::led_sync {

LedBoardSource::LedBoardSource(LedBoardOptions options, std::unique_ptr<link::ByteStream> stream, Clock now)
    : ByteSource(std::move(options.name), std::move(stream)),
      board_(options.board),
      sets_up_(options.sets_up && this->stream().is_live()),
      now_(std::move(now)) {}

StreamId LedBoardSource::declare(StreamTable& streams) {
  const StreamInfo raw = wire::raw_stream(name(), board_, stream().description());
  const StreamId id = streams.add(raw);
  for (const auto what : {wire::kLedBoardTime, wire::kLedBoardEdge, wire::kLedBoardProbe}) {
    streams.add(wire::led_board_stream(raw, what));
  }
  return id;
}

Result<void> LedBoardSource::connected() {
  if (sets_up_) set_up();
  return {};
}

Result<void> LedBoardSource::talk(std::span<const std::byte> received) {
  if (!received.empty()) last_byte_ = now_();
  if (sets_up_ && now_() - last_byte_ > kSilence) set_up();
  return {};
}

void LedBoardSource::set_up() {
  using Kind = wire::LedBoardCommand::Kind;
  last_byte_ = now_();
  const std::string commands =
      wire::encode_led_board_command({Kind::version}) + wire::encode_led_board_command({Kind::set_tick_length, board_.tick_us});
  // Where nobody is there to be told, the next silence is another chance; a link that is lost is for read to tell.
  static_cast<void>(stream().write(std::as_bytes(std::span(commands))).has_value());
}

}  // namespace roseau::led_sync
