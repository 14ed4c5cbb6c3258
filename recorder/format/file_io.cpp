#include "recorder/format/file_io.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <new>
#include <utility>

namespace roseau::mcap {

namespace {

constexpr std::uint64_t kReserveStep = 64U << 20U;
constexpr std::uint64_t kWritebackStep = 8U << 20U;
constexpr std::size_t kMaxParts = 256;  // per writev; IOV_MAX is 1024

// O_DIRECT wants offsets, sizes and memory in whole blocks: 4096 does for every disk.
constexpr std::size_t kBlockBytes = 4096;
constexpr std::size_t kStagingBytes = 1U << 20U;          // stays in the processor's cache
constexpr std::uint64_t kLeastDirectBytes = 256U << 10U;  // below, the page cache is cheaper

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
      return ": was the disk unplugged, or has it errors? See dmesg; record to another disk";
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

void FileWritable::AlignedDelete::operator()(std::byte* bytes) const {
  ::operator delete[](bytes, std::align_val_t{kBlockBytes});
}

Error FileWritable::failure(const char* what, int error_number) const { return file_error(what, path_, error_number); }

Result<void> FileWritable::append(Parts parts) {
  if (broken_) return *broken_;
  std::uint64_t bytes = 0;
  for (const auto& part : parts) bytes += part.size();
  if (auto reserved = reserve(bytes); !reserved) return reserved;
  const std::uint64_t size_before = size_;
  const bool direct = direct_fd_ >= 0 && bytes >= kLeastDirectBytes;
  auto written = direct ? write_direct(parts) : write_parts(parts);
  if (written) {
    keep_tail(parts, size_before);
    start_writeback();
  } else if (size_ != size_before) {
    take_back(size_before, written.error());
  } else if (direct && written.error().code == ErrorCode::unsupported) {
    ::close(std::exchange(direct_fd_, -1));
    return append(parts);
  }
  return written;
}

void FileWritable::take_back(std::uint64_t size_before, const Error& error) {
  const auto end = static_cast<off_t>(size_before);
  if (::ftruncate(fd_, end) != 0 || ::lseek(fd_, end, SEEK_SET) != end) broken_ = error;
  size_ = size_before;
}

void FileWritable::keep_tail(Parts parts, std::uint64_t size_before) {
  if (direct_fd_ < 0) return;
  const std::size_t wanted = size_ % kBlockBytes;
  if (size_ - size_before < wanted) {  // still the same block
    for (const auto& part : parts) tail_.insert(tail_.end(), part.begin(), part.end());
    return;
  }
  tail_.resize(wanted);
  std::size_t missing = wanted;
  for (std::size_t i = parts.size(); i > 0 && missing > 0; --i) {
    const auto part = parts[i - 1];
    const std::size_t used = std::min(missing, part.size());
    missing -= used;
    std::ranges::copy(part.last(used), tail_.begin() + static_cast<std::ptrdiff_t>(missing));
  }
}

/// Whole blocks directly, beginning with the one that is unfinished so far; the rest through the page cache, so that the file
/// always has its true size and a crash leaves nothing behind its end.
Result<void> FileWritable::write_direct(Parts parts) {
  if (!staging_) {
    staging_.reset(static_cast<std::byte*>(::operator new[](kStagingBytes, std::align_val_t{kBlockBytes})));
  }
  const std::span<std::byte> staging(staging_.get(), kStagingBytes);
  std::ranges::copy(tail_, staging.begin());
  std::size_t staged = tail_.size();
  for (auto part : parts) {
    while (!part.empty()) {
      const auto some = part.first(std::min(part.size(), kStagingBytes - staged));
      std::memcpy(staging.data() + staged, some.data(), some.size());
      staged += some.size();
      part = part.subspan(some.size());
      if (staged < kStagingBytes) continue;
      if (auto written = write_staged(staged); !written) return written;
      staged = 0;
    }
  }
  const std::size_t whole = staged - staged % kBlockBytes;
  if (auto written = write_staged(whole); !written) return written;
  if (::lseek(fd_, static_cast<off_t>(size_), SEEK_SET) < 0) return failure("cannot write", errno);
  const std::span<const std::byte> rest[] = {staging.subspan(whole, staged - whole)};
  return write_parts(rest);
}

/// The first `bytes` (whole blocks) of the staging buffer, at the last block border before the end.
Result<void> FileWritable::write_staged(std::size_t bytes) {
  std::size_t done = 0;
  const std::uint64_t offset = size_ - size_ % kBlockBytes;
  while (done < bytes) {
    const ssize_t written = ::pwrite(direct_fd_, staging_.get() + done, bytes - done, static_cast<off_t>(offset + done));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0 && errno == EINVAL && done == 0) {
      return Error{ErrorCode::unsupported, "this file system has O_DIRECT in name only"};
    }
    if (written <= 0) return failure("cannot write", written < 0 ? errno : EIO);
    done += static_cast<std::size_t>(written);
    size_ = std::max(size_, offset + done);
  }
  return {};
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

/// A file system that became read-only under us (a disk that was unplugged or has errors) may take writes into the page cache
/// and even say that they were synced: the kernel loses them in silence. So it is asked each time.
Result<void> FileWritable::sync() {
  if (::fdatasync(fd_) != 0 && errno != EINVAL) return failure("cannot write", errno);  // EINVAL: not a file that can be synced
  struct statvfs file_system {};
  if (::fstatvfs(fd_, &file_system) == 0 && (file_system.f_flag & ST_RDONLY) != 0) return failure("cannot write", EROFS);
  return {};
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
