// A serial port: UART, USB adapter, or the far side of a pseudo terminal.
//
// libserialport sets real ports up. It refuses pseudo terminals (no entry in /sys/class/tty, no modem lines), which
// emulators, socat and tests give us: those we set up ourselves; the rate then only serves to date bytes.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "drivers/link/byte_stream.h"
#include "drivers/link/first_byte_time.h"
#include "drivers/link/link_spec.h"
#include "drivers/link/posix.h"

namespace roseau::link {

/// Owns libserialport's port. Its descriptor stays libserialport's to close.
class LibserialPort;

class SerialStream : public ByteStream {
 public:
  SerialStream(std::string path, const SerialSettings& settings);
  ~SerialStream() override;

  /// Takes the port for us alone (TIOCEXCL and flock), so that two programs never share one instrument's bytes.
  Result<void> open() override;
  Result<Received> read(std::span<std::byte> buffer, std::chrono::milliseconds timeout) override;
  Result<void> write(std::span<const std::byte> bytes) override;
  void close() override;
  std::string description() const override { return "serial port " + path_; }
  Duration byte_time() const override { return settings_.byte_time(); }

 private:
  Result<void> check_access() const;
  Result<void> open_pseudo_terminal();
  Result<void> open_uart();
  Result<void> lock() const;
  std::uint16_t new_line_errors();

  std::string path_;
  SerialSettings settings_;
  FirstByteTime first_byte_time_;
  std::unique_ptr<LibserialPort> uart_;
  FileDescriptor pseudo_terminal_;
  int fd_ = -1;  // of whichever of the two is open
  bool counts_line_errors_ = false;
  std::uint32_t line_errors_before_ = 0;
};

}  // namespace roseau::link
