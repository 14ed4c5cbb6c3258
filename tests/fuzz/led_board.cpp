// Any bytes, cut two ways, give the same board times and counters; every line that is read is written again the same.
#include "drivers/wire/led_board.h"

#include "tests/fuzz/feed.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roseau;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  wire::LedBoardDecoder whole({});
  wire::LedBoardDecoder cut({});
  fuzz::check_cuts(whole, cut, text);
  if (const auto message = wire::parse_led_board(text)) {
    const std::string line = wire::encode_led_board(*message);
    const auto again = wire::parse_led_board(std::string_view(line).substr(0, line.size() - 2));
    ROSEAU_CHECK(again && wire::encode_led_board(*again) == line);
  }
  if (const auto command = wire::parse_led_board_command(text)) {
    ROSEAU_CHECK(!wire::encode_led_board_command(*command).empty());
  }
  return 0;
}
