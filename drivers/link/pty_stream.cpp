#include "drivers/link/pty_stream.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <thread>

namespace roseau::link {

std::string PtyStream::description() const { return "pseudo terminal " + (port_path_.empty() ? link_path_ : port_path_); }

Result<void> PtyStream::open() {
  close();
  FileDescriptor master(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!master.is_open()) return system_error(errno, "no pseudo terminal to be had");
  std::array<char, 64> name{};
  if (::grantpt(master.get()) != 0 || ::unlockpt(master.get()) != 0 ||
      ::ptsname_r(master.get(), name.data(), name.size()) != 0) {
    return system_error(errno, "no pseudo terminal to be had");
  }
  // Raw from the start, so that nothing is echoed or translated before the reader sets its own mode. Opening and closing
  // the other side also makes its absence visible (POLLHUP).
  const FileDescriptor port(::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  termios raw{};
  if (!port.is_open() || ::tcgetattr(port.get(), &raw) != 0) return system_error(errno, name.data());
  ::cfmakeraw(&raw);
  if (::tcsetattr(port.get(), TCSANOW, &raw) != 0) return system_error(errno, name.data());
  master_ = std::move(master);
  port_path_ = name.data();
  auto linked = make_link();
  if (!linked) close();
  return linked;
}

Result<void> PtyStream::make_link() {
  if (link_path_.empty()) return {};
  // A link that an earlier run left behind may go; anything else may not.
  struct stat status {};
  const bool exists = ::lstat(link_path_.c_str(), &status) == 0;
  if (exists && !S_ISLNK(status.st_mode)) {
    return Error{ErrorCode::busy, "pseudo terminal link " + link_path_ + " would replace a file: choose another path"};
  }
  if (exists) ::unlink(link_path_.c_str());
  if (::symlink(port_path_.c_str(), link_path_.c_str()) != 0) {
    return system_error(errno, "pseudo terminal link " + link_path_ + " cannot be made");
  }
  has_link_ = true;
  return {};
}

bool PtyStream::somebody_listens() const {
  pollfd polled{.fd = master_.get(), .events = 0, .revents = 0};
  return ::poll(&polled, 1, 0) == 0 || (polled.revents & POLLHUP) == 0;
}

Result<Received> PtyStream::read(std::span<std::byte> buffer, std::chrono::milliseconds timeout) {
  ROSEAU_CHECK(master_.is_open());
  const auto bytes = read_available(master_.get(), buffer, timeout, description());
  if (bytes) return Received{.size = bytes->size, .first_byte_time = bytes->read_time};
  if (bytes.error().code != ErrorCode::disconnected) return bytes.error();
  // Nobody has the port open. poll returns at once then; the nap keeps a reading loop from spinning.
  std::this_thread::sleep_for(std::min(timeout, std::chrono::milliseconds{10}));
  return Received{};
}

Result<void> PtyStream::write(std::span<const std::byte> bytes) {
  ROSEAU_CHECK(master_.is_open());
  if (!somebody_listens()) return {};
  auto written = write_all(master_.get(), bytes, kWriteTimeout, description());
  if (!written && written.error().code == ErrorCode::disconnected) return {};
  return written;
}

void PtyStream::close() {
  if (has_link_) ::unlink(link_path_.c_str());
  has_link_ = false;
  port_path_.clear();
  master_.reset();
}

}  // namespace roseau::link
