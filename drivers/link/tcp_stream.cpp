#include "drivers/link/tcp_stream.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>

#include <cerrno>

#include "drivers/link/inet.h"

namespace roseau::link {

namespace {

// A peer that vanished without a word (cable, power) is noticed after about 10 s + 3 x 5 s.
void set_up_connection(int fd) {
  constexpr int kOn = 1;
  constexpr int kIdleSeconds = 10;
  constexpr int kIntervalSeconds = 5;
  constexpr int kProbes = 3;
  ::setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &kOn, sizeof(kOn));
  ::setsockopt(fd, IPPROTO_TCP, TCP_KEEPIDLE, &kIdleSeconds, sizeof(kIdleSeconds));
  ::setsockopt(fd, IPPROTO_TCP, TCP_KEEPINTVL, &kIntervalSeconds, sizeof(kIntervalSeconds));
  ::setsockopt(fd, IPPROTO_TCP, TCP_KEEPCNT, &kProbes, sizeof(kProbes));
  // Small records must leave at once.
  ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &kOn, sizeof(kOn));
}

Error not_connected(int error_number, const std::string& description) {
  if (error_number == ECONNREFUSED) {
    return {ErrorCode::disconnected, description + " refuses the connection: is the device server or emulator running there?"};
  }
  return system_error(error_number, description + " cannot be reached");
}

Result<Received> receive(int fd, std::span<std::byte> buffer, std::chrono::milliseconds timeout, const std::string& description,
                         FirstByteTime& first_byte_time) {
  const auto bytes = read_available(fd, buffer, timeout, description);
  if (!bytes) return bytes.error();
  if (bytes->size == 0) return Received{};
  return Received{.size = bytes->size, .first_byte_time = first_byte_time.of_read(bytes->read_time, bytes->size)};
}

}  // namespace

TcpStream::TcpStream(std::string host, std::uint16_t port, Duration byte_time)
    : host_(std::move(host)), port_(port), first_byte_time_(byte_time) {}

std::string TcpStream::description() const { return "TCP connection to " + host_and_port(host_, port_); }

Result<void> TcpStream::open() {
  close();
  const auto address = resolve(host_, port_, SOCK_STREAM, description());
  if (!address) return address.error();
  auto socket = make_socket(*address, SOCK_STREAM, description());
  if (!socket) return socket.error();
  if (::connect(socket->get(), address->get(), address->length) != 0) {
    if (errno != EINPROGRESS) return not_connected(errno, description());
    const auto events = wait_for(socket->get(), POLLOUT, kConnectTimeout, description());
    if (!events) return events.error();
    if (*events == 0) return Error{ErrorCode::timeout, description() + ": no answer; check cable, address and port"};
    int failure = 0;
    socklen_t length = sizeof(failure);
    if (::getsockopt(socket->get(), SOL_SOCKET, SO_ERROR, &failure, &length) != 0) failure = errno;
    if (failure != 0) return not_connected(failure, description());
  }
  socket_ = std::move(*socket);
  set_up_connection(socket_.get());
  return {};
}

Result<Received> TcpStream::read(std::span<std::byte> buffer, std::chrono::milliseconds timeout) {
  ROSEAU_CHECK(socket_.is_open());
  return receive(socket_.get(), buffer, timeout, description(), first_byte_time_);
}

Result<void> TcpStream::write(std::span<const std::byte> bytes) {
  ROSEAU_CHECK(socket_.is_open());
  return write_all(socket_.get(), bytes, kWriteTimeout, description());
}

void TcpStream::close() {
  socket_.reset();
  first_byte_time_.reset();
}

TcpListenStream::TcpListenStream(std::string host, std::uint16_t port, Duration byte_time)
    : host_(std::move(host)), port_(port), first_byte_time_(byte_time) {}

std::string TcpListenStream::description() const { return "TCP port " + host_and_port(host_, port_); }

Result<void> TcpListenStream::open() {
  close();
  const auto address = resolve(host_, port_, SOCK_STREAM, description());
  if (!address) return address.error();
  auto socket = make_socket(*address, SOCK_STREAM, description());
  if (!socket) return socket.error();
  const auto bound = bind_socket(socket->get(), *address, description());
  if (!bound) return bound.error();
  if (::listen(socket->get(), 1) != 0) return system_error(errno, description() + " cannot be listened on");
  listener_ = std::move(*socket);
  port_ = bound->port();
  return {};
}

Result<void> TcpListenStream::accept_peer(std::chrono::milliseconds timeout) {
  const auto events = wait_for(listener_.get(), POLLIN, timeout, description());
  if (!events) return events.error();
  if (*events == 0) return {};
  peer_ = FileDescriptor(::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  // A caller that hung up before we answered is no failure of ours.
  if (!peer_.is_open()) return {};
  set_up_connection(peer_.get());
  first_byte_time_.reset();
  return {};
}

Result<Received> TcpListenStream::read(std::span<std::byte> buffer, std::chrono::milliseconds timeout) {
  ROSEAU_CHECK(listener_.is_open());
  if (!peer_.is_open()) {
    if (auto accepted = accept_peer(timeout); !accepted) return accepted.error();
    if (!peer_.is_open()) return Received{};
  }
  auto received = receive(peer_.get(), buffer, timeout, description(), first_byte_time_);
  if (!received) peer_.reset();
  return received;
}

Result<void> TcpListenStream::write(std::span<const std::byte> bytes) {
  ROSEAU_CHECK(listener_.is_open());
  if (!peer_.is_open()) {
    if (auto accepted = accept_peer(std::chrono::milliseconds{0}); !accepted) return accepted;
    if (!peer_.is_open()) return Error{ErrorCode::disconnected, description() + ": nobody has connected yet"};
  }
  auto written = write_all(peer_.get(), bytes, kWriteTimeout, description());
  if (!written) peer_.reset();
  return written;
}

void TcpListenStream::close() {
  peer_.reset();
  listener_.reset();
  first_byte_time_.reset();
}

}  // namespace roseau::link
