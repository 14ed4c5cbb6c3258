#include "drivers/link/udp_stream.h"

#include <poll.h>

#include <cerrno>

namespace roseau::link {

namespace {
// The kernel passes on that an earlier datagram found nobody; datagrams are sent in the hope of a listener.
bool nobody_listened(int error_number) { return error_number == ECONNREFUSED; }
bool nothing_there(int error_number) { return error_number == EAGAIN || error_number == EINTR; }
}  // namespace

UdpStream::UdpStream(UdpRole role, std::string host, std::uint16_t port) : role_(role), host_(std::move(host)), port_(port) {}

std::string UdpStream::description() const {
  return (role_ == UdpRole::send ? "UDP to " : "UDP port ") + host_and_port(host_, port_);
}

Result<void> UdpStream::open() {
  close();
  const auto address = resolve(host_, port_, SOCK_DGRAM, description());
  if (!address) return address.error();
  auto socket = make_socket(*address, SOCK_DGRAM, description());
  if (!socket) return socket.error();
  if (role_ == UdpRole::send) {
    if (::connect(socket->get(), address->get(), address->length) != 0) {
      return system_error(errno, description() + " cannot be reached");
    }
    peer_ = *address;
  } else {
    const auto bound = bind_socket(socket->get(), *address, description());
    if (!bound) return bound.error();
    port_ = bound->port();
  }
  socket_ = std::move(*socket);
  return {};
}

Result<Received> UdpStream::read(std::span<std::byte> buffer, std::chrono::milliseconds timeout) {
  ROSEAU_CHECK(socket_.is_open());
  const auto events = wait_for(socket_.get(), POLLIN, timeout, description());
  if (!events) return events.error();
  if (*events == 0) return Received{};
  SocketAddress sender;
  const ssize_t count = ::recvfrom(socket_.get(), buffer.data(), buffer.size(), 0, sender.get(), &sender.length);
  const int read_error = errno;
  const HostTime read_time = monotonic_now();
  if (count < 0) {
    if (nothing_there(read_error) || nobody_listened(read_error)) return Received{};
    return system_error(read_error, description());
  }
  if (role_ == UdpRole::listen) peer_ = sender;
  return Received{.size = static_cast<std::size_t>(count), .first_byte_time = read_time};
}

Result<void> UdpStream::write(std::span<const std::byte> bytes) {
  ROSEAU_CHECK(socket_.is_open());
  if (!peer_)
    return Error{ErrorCode::disconnected, description() + ": nobody has sent anything yet, so there is nobody to answer"};
  // A connected socket takes no address; MSG_NOSIGNAL as everywhere.
  const bool is_connected = role_ == UdpRole::send;
  const ssize_t count = ::sendto(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL, is_connected ? nullptr : peer_->get(),
                                 is_connected ? 0 : peer_->length);
  if (count < 0 && !nobody_listened(errno)) return system_error(errno, description());
  return {};
}

void UdpStream::close() {
  socket_.reset();
  peer_.reset();
}

}  // namespace roseau::link
