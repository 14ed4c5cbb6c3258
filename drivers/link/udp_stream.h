// UDP: one datagram per write, one datagram per read (the tail of one that does not fit the buffer is lost).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "drivers/link/byte_stream.h"
#include "drivers/link/inet.h"
#include "drivers/link/posix.h"

namespace roseau::link {

enum class UdpRole : std::uint8_t {
  send,    // to a stated address; reads are its answers
  listen,  // on an address of ours; writes answer the last sender
};

class UdpStream : public ByteStream {
 public:
  UdpStream(UdpRole role, std::string host, std::uint16_t port);

  Result<void> open() override;
  Result<Received> read(std::span<std::byte> buffer, std::chrono::milliseconds timeout) override;
  Result<void> write(std::span<const std::byte> bytes) override;
  void close() override;
  std::string description() const override;
  Duration byte_time() const override { return Duration{0}; }
  bool keeps_messages_apart() const override { return true; }

  /// As TcpListenStream::port.
  std::uint16_t port() const { return port_; }

 private:
  UdpRole role_;
  std::string host_;
  std::uint16_t port_;
  FileDescriptor socket_;
  std::optional<SocketAddress> peer_;
};

}  // namespace roseau::link
