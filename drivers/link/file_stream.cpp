#include "drivers/link/file_stream.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace roseau::link {

Result<void> FileStream::open() {
  close();
  FileDescriptor file(::open(path_.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat status {};
  if (!file.is_open() || ::fstat(file.get(), &status) != 0) return system_error(errno, description() + " cannot be opened");
  if (S_ISDIR(status.st_mode)) return Error{ErrorCode::invalid_argument, description() + " is a folder: name a file in it"};
  file_ = std::move(file);
  next_byte_time_ = monotonic_now();
  return {};
}

Result<Received> FileStream::read(std::span<std::byte> buffer, std::chrono::milliseconds /*timeout*/) {
  ROSEAU_CHECK(file_.is_open());
  const ssize_t count = ::read(file_.get(), buffer.data(), buffer.size());
  if (count < 0) return system_error(errno, description());
  const Received received{
      .size = static_cast<std::size_t>(count), .first_byte_time = next_byte_time_, .finished = count == 0 && !buffer.empty()};
  next_byte_time_ += byte_time_ * count;
  return received;
}

Result<void> FileStream::write(std::span<const std::byte> /*bytes*/) {
  return Error{ErrorCode::unsupported, description() + " takes no commands: it is a recording"};
}

void FileStream::close() { file_.reset(); }

}  // namespace roseau::link
