#include "recorder/format/file_io.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace roseau::mcap {

namespace {

constexpr std::uint64_t kReserveStep = 64U << 20U;
constexpr std::uint64_t kWritebackStep = 8U << 20U;
constexpr std::size_t kMaxParts = 256;  // per writev; IOV_MAX is 1024

ErrorCode code_of(int error_number) {
  switch (error_number) {
    case ENOSPC:
    case EDQUOT:
      return ErrorCode::no_space;
    case ENOENT:
    case ENOTDIR:
      return ErrorCode::not_found;
    case EACCES:
    case EPERM:
    case EROFS:
      return ErrorCode::permission;
    case EEXIST:
      return ErrorCode::invalid_argument;
    default:
      return ErrorCode::io;
  }
}

const char* advice_for(int error_number) {
  switch (error_number) {
    case ENOSPC:
      return ": free some space or record to another disk";
    case EDQUOT:
      return ": your disk quota is used up";
    case EEXIST:
      return ": move it away or choose another name (a session is never overwritten)";
    case EROFS:
      return ": remount the disk for writing or record elsewhere";
    default:
      return "";
  }
}

Error file_error(const char* what, const std::string& path, int error_number) {
  return {code_of(error_number),
          std::string(what) + " " + path + ": " + std::strerror(error_number) + advice_for(error_number)};
}

/// The new file's name must survive a power cut too. Best effort: some file systems cannot, and the file is there anyhow.
void sync_directory(const std::filesystem::path& file) {
  const auto directory = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  const int fd = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  static_cast<void>(::fsync(fd));
  ::close(fd);
}

}  // namespace

// ---------------------------------------------------------------------------------------------------------------------
// FileWritable

Result<std::unique_ptr<FileWritable>> FileWritable::create(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (fd < 0) return file_error("cannot create", path.string(), errno);
  sync_directory(path);
  return adopt(fd, path.string());
}

std::unique_ptr<FileWritable> FileWritable::adopt(int fd, std::string path) {
  return std::unique_ptr<FileWritable>(new FileWritable(fd, std::move(path)));
}

FileWritable::~FileWritable() {
  if (fd_ >= 0) ::close(fd_);
}

Error FileWritable::failure(const char* what, int error_number) const { return file_error(what, path_, error_number); }

Result<void> FileWritable::append(std::span<const std::span<const std::byte>> parts) {
  if (broken_) return *broken_;
  std::uint64_t bytes = 0;
  for (const auto& part : parts) bytes += part.size();
  if (auto reserved = reserve(bytes); !reserved) return reserved;
  const std::uint64_t size_before = size_;
  auto written = write_parts(parts);
  if (!written && size_ != size_before) {
    const auto end = static_cast<off_t>(size_before);
    if (::ftruncate(fd_, end) != 0 || ::lseek(fd_, end, SEEK_SET) != end) broken_ = written.error();
    size_ = size_before;
  }
  if (written) start_writeback();
  return written;
}

Result<void> FileWritable::write_parts(std::span<const std::span<const std::byte>> parts) {
  std::array<iovec, kMaxParts> vectors;
  for (std::size_t at = 0; at < parts.size(); at += kMaxParts) {
    const auto some = parts.subspan(at, std::min(kMaxParts, parts.size() - at));
    std::ranges::transform(some, vectors.begin(), [](const auto& part) {
      return iovec{const_cast<std::byte*>(part.data()), part.size()};  // writev only reads; its type does not say so
    });
    if (auto written = write_all(std::span(vectors).first(some.size())); !written) return written;
  }
  return {};
}

Result<void> FileWritable::write_all(std::span<iovec> parts) {
  while (!parts.empty()) {
    if (parts.front().iov_len == 0) {
      parts = parts.subspan(1);
      continue;
    }
    const ssize_t written = ::writev(fd_, parts.data(), static_cast<int>(parts.size()));
    if (written < 0) {
      if (errno == EINTR) continue;
      return failure("cannot write", errno);
    }
    auto left = static_cast<std::size_t>(written);
    size_ += left;
    while (left > 0) {
      iovec& part = parts.front();
      const std::size_t used = std::min(left, part.iov_len);
      part.iov_base = static_cast<std::byte*>(part.iov_base) + used;
      part.iov_len -= used;
      left -= used;
      if (part.iov_len == 0) parts = parts.subspan(1);
    }
  }
  return {};
}

Result<void> FileWritable::reserve(std::uint64_t bytes) {
  const std::uint64_t needed = size_ + bytes + (closing_ ? 0 : kReserveBytes);
  if (!can_reserve_ || needed <= reserved_until_) return {};
  // In large steps while there is room, then exactly what is needed.
  for (const std::uint64_t until : {needed + kReserveStep, needed}) {
    const std::uint64_t length = until - reserved_until_;
    if (::fallocate(fd_, FALLOC_FL_KEEP_SIZE, static_cast<off_t>(reserved_until_), static_cast<off_t>(length)) == 0) {
      reserved_until_ = until;
      return {};
    }
    if (errno != ENOSPC && errno != EDQUOT) {
      can_reserve_ = false;  // not a file, or a file system without this: the writes themselves will tell
      return {};
    }
  }
  return failure("cannot write", errno);
}

// The kernel would otherwise gather dirty pages for many seconds and then make one sync wait for all of them.
void FileWritable::start_writeback() {
  if (size_ - writeback_until_ < kWritebackStep) return;
  const auto from = static_cast<off_t>(writeback_until_);
  static_cast<void>(::sync_file_range(fd_, from, static_cast<off_t>(size_) - from, SYNC_FILE_RANGE_WRITE));
  writeback_until_ = size_;
}

Result<void> FileWritable::sync() {
  if (::fdatasync(fd_) == 0 || errno == EINVAL || errno == EROFS) return {};  // EINVAL: not a file that can be synced
  return failure("cannot write", errno);
}

Result<void> FileWritable::close() {
  Result<void> result = sync();
  if (can_reserve_ && reserved_until_ > size_ && ::ftruncate(fd_, static_cast<off_t>(size_)) != 0 && result) {
    result = failure("cannot shorten", errno);
  }
  if (::close(std::exchange(fd_, -1)) != 0 && result) result = failure("cannot close", errno);
  return result;
}

// ---------------------------------------------------------------------------------------------------------------------
// FileReadable

Result<std::unique_ptr<FileReadable>> FileReadable::open(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return file_error("cannot open", path.string(), errno);
  struct stat status {};
  if (::fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) {
    const int error_number = errno;
    const bool directory = S_ISDIR(status.st_mode);
    ::close(fd);
    if (status.st_mode == 0) return file_error("cannot open", path.string(), error_number);
    return Error{ErrorCode::invalid_argument,
                 path.string() + (directory ? " is a directory: name the session file in it" : " is not a file")};
  }
  static_cast<void>(::posix_fadvise(fd, 0, 0, POSIX_FADV_SEQUENTIAL));
  return std::unique_ptr<FileReadable>(new FileReadable(fd, static_cast<std::uint64_t>(status.st_size), path.string()));
}

FileReadable::~FileReadable() { ::close(fd_); }

Result<void> FileReadable::read(std::uint64_t offset, std::span<std::byte> to) {
  ROSEAU_CHECK(offset <= size_ && to.size() <= size_ - offset);
  while (!to.empty()) {
    const ssize_t got = ::pread(fd_, to.data(), to.size(), static_cast<off_t>(offset));
    if (got < 0) {
      if (errno == EINTR) continue;
      return file_error("cannot read", path_, errno);
    }
    if (got == 0) return Error{ErrorCode::truncated, path_ + " became shorter while it was read"};
    to = to.subspan(static_cast<std::size_t>(got));
    offset += static_cast<std::uint64_t>(got);
  }
  return {};
}

}  // namespace roseau::mcap
