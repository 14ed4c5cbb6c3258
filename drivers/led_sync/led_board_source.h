// An LED synchronisation board on a byte stream: tells it its tick, and hands on its bytes as they come. Decoding happens
// behind the point where they are recorded (drivers/wire/led_board.h).
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "drivers/link/byte_source.h"
#include "drivers/link/posix.h"
#include "drivers/wire/led_board.h"

namespace roseau::led_sync {

struct LedBoardOptions {
  std::string name = "led_board";
  wire::LedBoardOptions board;
  bool sets_up = true;  // false: the board keeps the tick it has; we only listen
};

/// Emits RawBytes on "/<name>/raw" and declares "/<name>/time", "/<name>/edge" and "/<name>/probe".
///
/// The board sends by itself. It is told its tick's length and asked for its version when it is connected, and again when it
/// has been silent for kSilence (it was plugged in anew); its answer is what the decoder believes.
class LedBoardSource : public link::ByteSource {
 public:
  static constexpr Duration kSilence = std::chrono::seconds(2);

  using Clock = std::function<HostTime()>;
  LedBoardSource(LedBoardOptions options, std::unique_ptr<link::ByteStream> stream, Clock now = link::monotonic_now);

 protected:
  StreamId declare(StreamTable& streams) override;
  Result<void> connected() override;
  Result<void> talk(std::span<const std::byte> received) override;

 private:
  void set_up();

  wire::LedBoardOptions board_;
  bool sets_up_;
  Clock now_;
  HostTime last_byte_;
};

}  // namespace roseau::led_sync
