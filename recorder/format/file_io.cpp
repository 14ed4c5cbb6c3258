#include "recorder/format/file_io.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace roseau::mcap {

namespace {

// Each step makes the writes wait for a moment: the longer the recording, the larger.
constexpr std::uint64_t kLeastReserveStep = 64U << 20U;
constexpr std::uint64_t kMostReserveStep = 512U << 20U;
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
    case EFBIG:
      return ": this disk takes no larger files: split the recording, or record to another disk";
    case EIO:
    case ENODEV:
    case EROFS:  // what the system took since the last sync and has not written is gone
      return ": was the disk unplugged, or has it errors? See dmesg. Up to two seconds that were counted as recorded may be "
             "lost; "
             "record to another disk";
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
  // Whoever recovers sessions sees that this one is still being written. Where locks are not known it cannot.
  static_cast<void>(::flock(fd, LOCK_EX | LOCK_NB));
  sync_directory(path);
  auto file = adopt(fd, path.string());
  file->direct_fd_ = ::open(path.c_str(), O_WRONLY | O_DIRECT | O_CLOEXEC);
  return file;
}

std::unique_ptr<FileWritable> FileWritable::adopt(int fd, std::string path) {
  return std::unique_ptr<FileWritable>(new FileWritable(fd, std::move(path)));
}

FileWritable::~FileWritable() {
  for (const int fd : {fd_, direct_fd_}) {
    if (fd >= 0) ::close(fd);
  }
}

Error FileWritable::failure(const char* what, int error_number) const { return file_error(what, path_, error_number); }

Result<void> FileWritable::append(Parts parts) {
  if (broken_) return *broken_;
  std::uint64_t bytes = 0;
  for (const auto& part : parts) bytes += part.size();
  if (auto reserved = reserve(bytes); !reserved) return reserved;
  // Only where space is reserved can a write be put off: elsewhere a full disk would be noticed too late for a proper end.
  if (size_ == 0 && !direct_ && direct_fd_ >= 0 && can_reserve_) {
    direct_ = std::make_unique<DirectWriter>(fd_, direct_fd_, path_, file_error);
  }
  if (direct_) {
    auto appended = direct_->append(parts);
    if (appended) size_ += bytes;
    return appended;
  }
  const std::uint64_t size_before = size_;
  auto written = write_parts(parts);
  if (written) {
    start_writeback();
  } else if (size_ != size_before) {
    take_back(size_before, written.error());
  }
  return written;
}

std::uint64_t FileWritable::written() const { return direct_ ? direct_->written() : size_; }

Result<void> FileWritable::flush() { return direct_ ? direct_->flush() : Result<void>{}; }

Result<void> FileWritable::begin_sync() { return direct_ ? direct_->begin_sync() : sync(); }

void FileWritable::take_back(std::uint64_t size_before, const Error& error) {
  const auto end = static_cast<off_t>(size_before);
  if (::ftruncate(fd_, end) != 0 || ::lseek(fd_, end, SEEK_SET) != end) broken_ = error;
  size_ = size_before;
}

Result<void> FileWritable::write_parts(Parts parts) {
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
  const std::uint64_t needed = size_ + bytes + (closing_ ? 0 : kReserveBytes + end_bytes_);
  if (!can_reserve_ || needed <= reserved_until_) return {};
  // In large steps while there is room, then exactly what is needed.
  const std::uint64_t step = std::clamp(size_ / 4, kLeastReserveStep, kMostReserveStep);
  for (const std::uint64_t until : {needed + step, needed}) {
    const std::uint64_t length = until - reserved_until_;
    if (::fallocate(fd_, FALLOC_FL_KEEP_SIZE, static_cast<off_t>(reserved_until_), static_cast<off_t>(length)) == 0) {
      reserved_until_ = until;
      return {};
    }
    if (errno != ENOSPC && errno != EDQUOT && errno != EFBIG) {
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
  if (direct_) {
    if (auto drained = direct_->drain(); !drained) return drained;
  }
  if (const int error_number = sync_file(fd_); error_number != 0) return failure("cannot write", error_number);
  return {};
}

Result<void> FileWritable::close() {
  Result<void> result = sync();
  if (!result && direct_) size_ = direct_->written();
  direct_.reset();
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
