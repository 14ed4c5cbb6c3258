// ByteStream: bytes to and from a device, wherever they travel: serial port, TCP, UDP, pseudo terminal, file. Real drivers
// and the emulators they are tried against meet here.
//
// Used by one thread at a time. After an Error from read or write the stream is lost: close it and open it again.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "core/result.h"
#include "core/time.h"

namespace roseau::link {

/// What one read brought.
struct Received {
  std::size_t size = 0;           // bytes put into the buffer; 0: nothing came within the timeout
  HostTime first_byte_time;       // of buffer[0]; says nothing while size is 0
  std::uint16_t line_errors = 0;  // parity, framing, break and overrun errors since the read before; 0 where nobody tells
  bool finished = false;          // nothing will ever come again (end of a file)
};

class ByteStream {
 public:
  /// write gives up after this long without any progress.
  static constexpr std::chrono::milliseconds kWriteTimeout{1000};

  virtual ~ByteStream() = default;

  /// Connects. A stream that was closed, by us or by the other side, can be opened again.
  virtual Result<void> open() = 0;

  /// Waits at most `timeout` for the first byte, then takes what is there, without waiting for more. Error::disconnected:
  /// the other side is gone (unplugged, closed).
  virtual Result<Received> read(std::span<std::byte> buffer, std::chrono::milliseconds timeout) = 0;

  /// Sends all of `bytes`, or fails.
  virtual Result<void> write(std::span<const std::byte> bytes) = 0;

  virtual void close() = 0;

  /// For messages to people: "serial port /dev/ttyUSB0", "TCP port 127.0.0.1:4001".
  virtual std::string description() const = 0;

  /// Time one byte takes on the wire, 0 where it is unknown or does not matter. Byte i of a read began at
  /// first_byte_time + i * byte_time().
  virtual Duration byte_time() const = 0;

  /// False: bytes wait for us as long as we like (a file).
  virtual bool is_live() const { return true; }

  /// True: one read is one whole message of the sender (UDP), as far as it fits the buffer.
  virtual bool keeps_messages_apart() const { return false; }
};

}  // namespace roseau::link
