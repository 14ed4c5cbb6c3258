// TCP, either way round. Bytes come when the network brings them; with the byte time of the instrument's serial side (device
// servers) first bytes are dated as on a serial port.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/link/byte_stream.h"
#include "drivers/link/first_byte_time.h"
#include "drivers/link/posix.h"

namespace roseau::link {

/// We connect to the other side.
class TcpStream : public ByteStream {
 public:
  static constexpr std::chrono::milliseconds kConnectTimeout{2000};

  TcpStream(std::string host, std::uint16_t port, Duration byte_time);

  Result<void> open() override;
  Result<Received> read(std::span<std::byte> buffer, std::chrono::milliseconds timeout) override;
  Result<void> write(std::span<const std::byte> bytes) override;
  void close() override;
  std::string description() const override;
  Duration byte_time() const override { return first_byte_time_.byte_time(); }

 private:
  std::string host_;
  std::uint16_t port_;
  FirstByteTime first_byte_time_;
  FileDescriptor socket_;
};

/// The other side connects to us: one peer at a time, the next ones wait. When the peer leaves, read says so once
/// (disconnected); later reads wait for the next peer, so that a server may simply go on reading.
class TcpListenStream : public ByteStream {
 public:
  TcpListenStream(std::string host, std::uint16_t port, Duration byte_time);

  Result<void> open() override;
  Result<Received> read(std::span<std::byte> buffer, std::chrono::milliseconds timeout) override;
  /// disconnected while there is no peer.
  Result<void> write(std::span<const std::byte> bytes) override;
  void close() override;
  std::string description() const override;
  Duration byte_time() const override { return first_byte_time_.byte_time(); }

  /// The port we listen on: after the first open also where port 0 was asked for, and the same after a reopening.
  std::uint16_t port() const { return port_; }
  bool has_peer() const { return peer_.is_open(); }

 private:
  Result<void> accept_peer(std::chrono::milliseconds timeout);

  std::string host_;
  std::uint16_t port_;
  FirstByteTime first_byte_time_;
  FileDescriptor listener_;
  FileDescriptor peer_;
};

}  // namespace roseau::link
