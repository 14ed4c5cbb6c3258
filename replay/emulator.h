// Emulator: plays an instrument on a byte stream (a pseudo terminal, a socket), so that real drivers talk to it.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/emulated_instrument.h"
#include "core/result.h"
#include "core/time.h"
#include "drivers/link/byte_stream.h"

namespace roseau::replay {

/// One thread at a time.
class Emulator {
 public:
  struct Counters {
    std::uint64_t records_sent = 0;  // unasked
    std::uint64_t bytes_sent = 0;
    std::uint64_t bytes_received = 0;
  };
  using Clock = std::function<HostTime()>;

  /// The instrument starts at `start` on the clock `now`.
  Emulator(std::unique_ptr<link::ByteStream> stream, std::unique_ptr<EmulatedInstrument> instrument, HostTime start, Clock now);

  /// Opens the link. The instrument may be connected to from then on.
  Result<void> open();

  /// Answers what has come and sends what is due; waits for either at most `timeout`. Who listens may come and go. While the
  /// instrument's cable is pulled the link is closed. Error: the link itself is lost or cannot be opened again.
  Result<void> step(std::chrono::milliseconds timeout);

  const std::string& name() const { return instrument_->name(); }
  /// Where it can be connected to.
  std::string description() const { return stream_->description(); }
  const Counters& counters() const { return counters_; }

 private:
  Duration since_start() const { return now_() - start_; }
  Result<void> follow_cable(Duration now);
  Result<void> answer(std::chrono::milliseconds timeout);
  Result<void> send_due();
  Result<void> write(const std::string& bytes);

  std::unique_ptr<link::ByteStream> stream_;
  std::unique_ptr<EmulatedInstrument> instrument_;
  HostTime start_;
  Clock now_;
  bool is_open_ = false;
  Counters counters_;
};

}  // namespace roseau::replay
