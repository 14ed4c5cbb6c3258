#include "drivers/link/inet.h"

#include <netdb.h>
#include <netinet/in.h>

#include <cerrno>
#include <cstring>
#include <memory>

namespace roseau::link {

std::uint16_t SocketAddress::port() const {
  if (storage.ss_family == AF_INET6) {
    sockaddr_in6 address{};
    std::memcpy(&address, &storage, sizeof(address));
    return ntohs(address.sin6_port);
  }
  sockaddr_in address{};
  std::memcpy(&address, &storage, sizeof(address));
  return ntohs(address.sin_port);
}

std::string host_and_port(const std::string& host, std::uint16_t port) {
  const bool is_ipv6 = host.find(':') != std::string::npos;
  return (is_ipv6 ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

Result<SocketAddress> resolve(const std::string& host, std::uint16_t port, int socket_type, const std::string& description) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = socket_type;
  addrinfo* found = nullptr;
  const int failure = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found);
  if (failure != 0) {
    return Error{ErrorCode::not_found, description + ": host '" + host + "' is not known (" + ::gai_strerror(failure) +
                                           "): check its spelling, or write its address in numbers"};
  }
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
  SocketAddress address;
  std::memcpy(&address.storage, found->ai_addr, found->ai_addrlen);
  address.length = found->ai_addrlen;
  return address;
}

Result<FileDescriptor> make_socket(const SocketAddress& address, int socket_type, const std::string& description) {
  FileDescriptor socket(::socket(address.storage.ss_family, socket_type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket.is_open()) return system_error(errno, description);
  return socket;
}

Result<SocketAddress> bind_socket(int fd, const SocketAddress& address, const std::string& description) {
  // Else a listener that was just closed keeps its port for a minute.
  const int on = 1;
  ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  if (::bind(fd, address.get(), address.length) != 0) {
    if (errno == EADDRINUSE) {
      return Error{ErrorCode::busy, description + " is in use by another program: stop that one, or choose another port"};
    }
    if (errno == EADDRNOTAVAIL) {
      return Error{ErrorCode::invalid_argument,
                   description + " is no address of this machine: write 0.0.0.0 to listen on every interface"};
    }
    return system_error(errno, description + " cannot be listened on");
  }
  SocketAddress bound;
  if (::getsockname(fd, bound.get(), &bound.length) != 0) return system_error(errno, description);
  return bound;
}

}  // namespace roseau::link
