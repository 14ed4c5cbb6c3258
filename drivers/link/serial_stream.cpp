#include "drivers/link/serial_stream.h"

#include <fcntl.h>
#include <libserialport.h>
#include <linux/serial.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <limits>

#include "core/log.h"

namespace roseau::link {

// Wraps the C library: every call's failure as an Error, everything freed.
class LibserialPort {
 public:
  LibserialPort(std::string path, std::string description) : path_(std::move(path)), description_(std::move(description)) {}
  LibserialPort(const LibserialPort&) = delete;
  LibserialPort& operator=(const LibserialPort&) = delete;
  ~LibserialPort() {
    if (is_open_) sp_close(port_);
    if (port_ != nullptr) sp_free_port(port_);
  }

  Result<int> open() {
    if (auto result = check(sp_get_port_by_name(path_.c_str(), &port_), "is no serial port"); !result) return result.error();
    if (auto result = check(sp_open(port_, SP_MODE_READ_WRITE), "cannot be opened"); !result) return result.error();
    is_open_ = true;
    int fd = -1;
    if (auto result = check(sp_get_port_handle(port_, &fd), "has no descriptor"); !result) return result.error();
    return fd;
  }

  Result<void> configure(const SerialSettings& settings) {
    const std::string baud = "cannot do " + std::to_string(settings.baud) + " baud";
    if (auto result = check(sp_set_baudrate(port_, settings.baud), baud); !result) return result;
    if (auto result = check(sp_set_bits(port_, settings.data_bits), "refuses the number of data bits"); !result) return result;
    if (auto result = check(sp_set_parity(port_, parity(settings.parity)), "refuses the parity"); !result) return result;
    if (auto result = check(sp_set_stopbits(port_, settings.stop_bits), "refuses the number of stop bits"); !result)
      return result;
    return check(sp_set_flowcontrol(port_, flow_control(settings.flow_control)), "refuses the flow control");
  }

  // Some UARTs clamp a rate that they cannot do and report success.
  Result<void> verify_baud(int wanted) const {
    sp_port_config* config = nullptr;
    if (sp_new_config(&config) != SP_OK) return {};
    int actual = 0;
    const bool known = sp_get_config(port_, config) == SP_OK && sp_get_config_baudrate(config, &actual) == SP_OK && actual > 0;
    sp_free_config(config);
    constexpr int kTolerancePercent = 3;
    if (!known || std::abs(actual - wanted) * 100LL <= wanted * static_cast<long long>(kTolerancePercent)) return {};
    return Error{ErrorCode::unsupported, description_ + " was asked for " + std::to_string(wanted) + " baud and set " +
                                             std::to_string(actual) + ": choose a rate it can do, also on the instrument"};
  }

 private:
  static sp_parity parity(Parity parity) {
    if (parity == Parity::even) return SP_PARITY_EVEN;
    return parity == Parity::odd ? SP_PARITY_ODD : SP_PARITY_NONE;
  }
  static sp_flowcontrol flow_control(FlowControl flow) {
    if (flow == FlowControl::rts_cts) return SP_FLOWCONTROL_RTSCTS;
    return flow == FlowControl::xon_xoff ? SP_FLOWCONTROL_XONXOFF : SP_FLOWCONTROL_NONE;
  }
  Result<void> check(sp_return returned, const std::string& failure) const {
    if (returned >= SP_OK) return {};
    const std::string what = description_ + " " + failure;
    if (returned == SP_ERR_FAIL) return system_error(sp_last_error_code(), what);
    if (returned == SP_ERR_SUPP) return Error{ErrorCode::unsupported, what};
    return Error{ErrorCode::invalid_argument, what};
  }

  std::string path_;
  std::string description_;
  sp_port* port_ = nullptr;
  bool is_open_ = false;
};

namespace {

// Unix98 pseudo terminals: the far sides have the major device numbers 136 to 143 (Linux
// Documentation/admin-guide/devices.txt).
bool is_pseudo_terminal(const struct stat& status) {
  const unsigned int device = major(status.st_rdev);
  return S_ISCHR(status.st_mode) && device >= 136 && device <= 143;
}

// The serial-port drivers that batch bytes for throughput (8250, FTDI) pass each on at once with this flag. Those without
// such a knob refuse, and have no need of it.
void ask_for_low_latency(int fd) {
  serial_struct port{};
  if (::ioctl(fd, TIOCGSERIAL, &port) != 0) return;
  port.flags |= ASYNC_LOW_LATENCY;
  if (::ioctl(fd, TIOCSSERIAL, &port) != 0) return;
}

bool read_line_error_total(int fd, std::uint32_t& total) {
  serial_icounter_struct counters{};
  if (::ioctl(fd, TIOCGICOUNT, &counters) != 0) return false;
  total = static_cast<std::uint32_t>(counters.parity) + static_cast<std::uint32_t>(counters.frame) +
          static_cast<std::uint32_t>(counters.brk) + static_cast<std::uint32_t>(counters.overrun) +
          static_cast<std::uint32_t>(counters.buf_overrun);
  return true;
}

}  // namespace

SerialStream::SerialStream(std::string path, const SerialSettings& settings)
    : path_(std::move(path)), settings_(settings), first_byte_time_(settings.byte_time()) {}

SerialStream::~SerialStream() { close(); }

Result<void> SerialStream::check_access() const {
  if (::access(path_.c_str(), F_OK) != 0) {
    return Error{ErrorCode::not_found,
                 description() + " does not exist: is the adapter plugged in? `roseau devices` lists the ports there are"};
  }
  if (::faccessat(AT_FDCWD, path_.c_str(), R_OK | W_OK, AT_EACCESS) != 0) {
    return Error{ErrorCode::permission, description() + " may not be used by this user: add the user to group dialout " +
                                            "(sudo usermod -aG dialout $USER), then log in again"};
  }
  return {};
}

Result<void> SerialStream::lock() const {
  // flock keeps out other careful programs, TIOCEXCL also the careless ones (root excepted).
  if (::flock(fd_, LOCK_EX | LOCK_NB) != 0) {
    return Error{ErrorCode::busy,
                 description() + " is in use by another program: stop that one (`fuser -v " + path_ + "` names it)"};
  }
  if (::ioctl(fd_, TIOCEXCL) != 0) return system_error(errno, description() + " cannot be taken for us alone");
  return {};
}

Result<void> SerialStream::open_pseudo_terminal() {
  pseudo_terminal_ = FileDescriptor(::open(path_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!pseudo_terminal_.is_open()) return system_error(errno, description() + " cannot be opened");
  fd_ = pseudo_terminal_.get();
  if (auto locked = lock(); !locked) return locked;
  termios raw{};
  if (::tcgetattr(fd_, &raw) != 0) return system_error(errno, description() + " is no terminal");
  ::cfmakeraw(&raw);
  if (::tcsetattr(fd_, TCSANOW, &raw) != 0) return system_error(errno, description() + " cannot be set up");
  return {};
}

Result<void> SerialStream::open_uart() {
  uart_ = std::make_unique<LibserialPort>(path_, description());
  const auto fd = uart_->open();
  if (!fd && fd.error().code == ErrorCode::busy) {
    return Error{ErrorCode::busy,
                 description() + " is in use by another program: stop that one (`fuser -v " + path_ + "` names it)"};
  }
  if (!fd) return fd.error();
  fd_ = *fd;
  if (auto locked = lock(); !locked) return locked;
  if (auto configured = uart_->configure(settings_); !configured) return configured;
  if (auto verified = uart_->verify_baud(settings_.baud); !verified) return verified;
  ask_for_low_latency(fd_);
  // What piled up before we came has no arrival time.
  ::tcflush(fd_, TCIFLUSH);
  return {};
}

Result<void> SerialStream::open() {
  close();
  if (auto access = check_access(); !access) return access;
  struct stat status {};
  if (::stat(path_.c_str(), &status) != 0) return system_error(errno, description());
  auto opened = is_pseudo_terminal(status) ? open_pseudo_terminal() : open_uart();
  if (!opened) {
    close();
    return opened;
  }
  counts_line_errors_ = read_line_error_total(fd_, line_errors_before_);
  return {};
}

std::uint16_t SerialStream::new_line_errors() {
  std::uint32_t total = line_errors_before_;
  if (!counts_line_errors_ || !read_line_error_total(fd_, total)) return 0;
  const std::uint32_t fresh = total - line_errors_before_;
  line_errors_before_ = total;
  return static_cast<std::uint16_t>(std::min<std::uint32_t>(fresh, std::numeric_limits<std::uint16_t>::max()));
}

Result<Received> SerialStream::read(std::span<std::byte> buffer, std::chrono::milliseconds timeout) {
  ROSEAU_CHECK(fd_ >= 0);
  const auto bytes = read_available(fd_, buffer, timeout, description());
  if (!bytes) return bytes.error();
  if (bytes->size == 0) return Received{};
  return Received{.size = bytes->size,
                  .first_byte_time = first_byte_time_.of_read(bytes->read_time, bytes->size),
                  .line_errors = new_line_errors()};
}

Result<void> SerialStream::write(std::span<const std::byte> bytes) {
  ROSEAU_CHECK(fd_ >= 0);
  return write_all(fd_, bytes, kWriteTimeout, description());
}

void SerialStream::close() {
  // The mark outlives our descriptor where another program still holds the terminal.
  if (fd_ >= 0) ::ioctl(fd_, TIOCNXCL);
  fd_ = -1;
  uart_.reset();
  pseudo_terminal_.reset();
  first_byte_time_.reset();
}

}  // namespace roseau::link
