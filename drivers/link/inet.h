// Internet addresses and sockets for TCP and UDP.
#pragma once

#include <sys/socket.h>

#include <cstdint>
#include <string>

#include "core/result.h"
#include "drivers/link/posix.h"

namespace roseau::link {

/// An IPv4 or IPv6 address with its port, in the system's form.
struct SocketAddress {
  sockaddr_storage storage{};
  socklen_t length = sizeof(sockaddr_storage);

  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
  sockaddr* get() { return reinterpret_cast<sockaddr*>(&storage); }
  std::uint16_t port() const;
};

/// "127.0.0.1:4001", "[::1]:4001".
std::string host_and_port(const std::string& host, std::uint16_t port);

/// Looks up a name or number for a socket of this type (SOCK_STREAM, SOCK_DGRAM); the first answer counts.
Result<SocketAddress> resolve(const std::string& host, std::uint16_t port, int socket_type, const std::string& description);

/// A non-blocking socket that is closed on exec, of the address' family.
Result<FileDescriptor> make_socket(const SocketAddress& address, int socket_type, const std::string& description);

/// Binds to the address; the one really bound (its port chosen by the system if it was 0).
Result<SocketAddress> bind_socket(int fd, const SocketAddress& address, const std::string& description);

}  // namespace roseau::link
