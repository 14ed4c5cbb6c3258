// The little of POSIX that all streams share: owned file descriptors, waiting, reading, errors in words.
#pragma once

#include <chrono>
#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include "core/result.h"
#include "core/time.h"

namespace roseau::link {

/// Owns a file descriptor; closes it when it goes.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int fd) : fd_(fd) {}
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~FileDescriptor() { reset(); }

  int get() const { return fd_; }
  bool is_open() const { return fd_ >= 0; }
  void reset();

 private:
  int fd_ = -1;
};

/// CLOCK_MONOTONIC, the axis of every HostTime.
HostTime monotonic_now();

/// "<what>: <the system's words>", with the code that fits `error_number` (an errno value).
Error system_error(int error_number, const std::string& what);

/// Waits at most `timeout` for any of poll(2)'s `events`. The events that came; 0 when none did.
Result<short> wait_for(int fd, short events, std::chrono::milliseconds timeout, const std::string& description);

/// What read_available found.
struct ReadBytes {
  std::size_t size = 0;  // 0: nothing came
  HostTime read_time;    // when the read returned
};

/// Waits for bytes and takes what is there. The other side's leaving is Error::disconnected, naming `description`.
Result<ReadBytes> read_available(int fd, std::span<std::byte> buffer, std::chrono::milliseconds timeout,
                                 const std::string& description);

/// Writes all bytes to a non-blocking descriptor, waiting at most `timeout` for each piece of progress.
Result<void> write_all(int fd, std::span<const std::byte> bytes, std::chrono::milliseconds timeout,
                       const std::string& description);

}  // namespace roseau::link
