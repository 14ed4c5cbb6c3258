#include "drivers/link/posix.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>
#include <system_error>

namespace roseau::link {

namespace {

ErrorCode code_of(int error_number) {
  switch (error_number) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
    case ENOTDIR:
      return ErrorCode::not_found;
    case EACCES:
    case EPERM:
      return ErrorCode::permission;
    case EBUSY:
    case EADDRINUSE:
    case EWOULDBLOCK:
      return ErrorCode::busy;
    case ETIMEDOUT:
      return ErrorCode::timeout;
    case EINVAL:
    case EADDRNOTAVAIL:
      return ErrorCode::invalid_argument;
    case EPIPE:
    case ECONNRESET:
    case ECONNREFUSED:
    case ECONNABORTED:
    case EHOSTUNREACH:
    case ENETUNREACH:
      return ErrorCode::disconnected;
    default:
      return ErrorCode::io;
  }
}

// Errors of an open descriptor that mean that the device or the peer is gone.
bool means_gone(int error_number) {
  switch (error_number) {
    case EIO:
    case ENXIO:
    case ENODEV:
    case EPIPE:
    case ECONNRESET:
    case ETIMEDOUT:
      return true;
    default:
      return false;
  }
}

Error gone(const std::string& description) {
  return {ErrorCode::disconnected, description + " is disconnected: unplugged, switched off or closed by the other side"};
}

Error transfer_error(int error_number, const std::string& description) {
  if (means_gone(error_number)) return gone(description);
  return system_error(error_number, description);
}

}  // namespace

void FileDescriptor::reset() {
  if (fd_ >= 0) ::close(std::exchange(fd_, -1));
}

HostTime monotonic_now() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return HostTime{std::chrono::seconds{now.tv_sec} + std::chrono::nanoseconds{now.tv_nsec}};
}

Error system_error(int error_number, const std::string& what) {
  return {code_of(error_number), what + ": " + std::generic_category().message(error_number)};
}

Result<short> wait_for(int fd, short events, std::chrono::milliseconds timeout, const std::string& description) {
  pollfd polled{.fd = fd, .events = events, .revents = 0};
  const int ready = ::poll(&polled, 1, static_cast<int>(timeout.count()));
  if (ready < 0 && errno != EINTR) return system_error(errno, description);
  return ready > 0 ? polled.revents : short{0};
}

Result<ReadBytes> read_available(int fd, std::span<std::byte> buffer, std::chrono::milliseconds timeout,
                                 const std::string& description) {
  const auto events = wait_for(fd, POLLIN, timeout, description);
  if (!events) return events.error();
  if (*events == 0) return ReadBytes{};
  const ssize_t count = ::read(fd, buffer.data(), buffer.size());
  const int read_error = errno;
  const HostTime read_time = monotonic_now();
  if (count > 0) return ReadBytes{static_cast<std::size_t>(count), read_time};
  if (count == 0) {
    // Nothing to read from a socket or file is its end; from a terminal only if it was hung up.
    const bool still_there = ::isatty(fd) == 1 && (*events & (POLLHUP | POLLERR)) == 0;
    if (still_there) return ReadBytes{};
    return gone(description);
  }
  if (read_error == EAGAIN || read_error == EINTR) return ReadBytes{};
  return transfer_error(read_error, description);
}

Result<void> write_all(int fd, std::span<const std::byte> bytes, std::chrono::milliseconds timeout,
                       const std::string& description) {
  while (!bytes.empty()) {
    // send with MSG_NOSIGNAL where the descriptor is a socket: a peer that left must not raise SIGPIPE.
    ssize_t count = ::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count < 0 && errno == ENOTSOCK) count = ::write(fd, bytes.data(), bytes.size());
    if (count >= 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(count));
      continue;
    }
    if (errno == EINTR) continue;
    if (errno != EAGAIN) return transfer_error(errno, description);
    const auto events = wait_for(fd, POLLOUT, timeout, description);
    if (!events) return events.error();
    if (*events == 0) return Error{ErrorCode::timeout, description + " takes no bytes: is the other side reading?"};
    // Hung up: there will never be room.
    if ((*events & POLLOUT) == 0) return gone(description);
  }
  return {};
}

}  // namespace roseau::link
