#include "recorder/tools/recover/tail_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "recorder/format/file_io.h"

namespace roseau::recorder {

namespace {

constexpr std::uint64_t kCompareBytes = 1U << 20U;
constexpr std::uint64_t kMostTailBytes = std::uint64_t{1} << 30U;

ErrorCode code_of(int error_number) {
  if (error_number == ENOSPC || error_number == EDQUOT) return ErrorCode::no_space;
  if (error_number == ENOENT) return ErrorCode::not_found;
  if (error_number == EACCES || error_number == EPERM || error_number == EROFS) return ErrorCode::permission;
  return ErrorCode::io;
}

}  // namespace

Result<std::unique_ptr<TailFile>> TailFile::open(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return Error{code_of(errno), "cannot open " + path.string() + " for writing: " + std::strerror(errno)};
  struct stat status {};
  std::unique_ptr<TailFile> file(new TailFile(fd, 0, path));
  if (::fstat(fd, &status) != 0) return file->failure("cannot open", errno);
  if (!S_ISREG(status.st_mode)) return Error{ErrorCode::invalid_argument, path.string() + " is not a file"};
  file->size_ = static_cast<std::uint64_t>(status.st_size);
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return Error{ErrorCode::busy, path.string() + " is being recorded: stop that first"};
  }
  return file;
}

TailFile::~TailFile() { ::close(fd_); }

Error TailFile::failure(const char* what, int error_number) const {
  return {code_of(error_number), std::string(what) + " " + path_.string() + ": " + std::strerror(error_number)};
}

Result<void> TailFile::read(std::uint64_t offset, std::span<std::byte> to) {
  while (!to.empty()) {
    const ssize_t got = ::pread(fd_, to.data(), to.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return failure("cannot read", errno);
    if (got == 0) return Error{ErrorCode::truncated, path_.string() + " became shorter while it was read"};
    to = to.subspan(static_cast<std::size_t>(got));
    offset += static_cast<std::uint64_t>(got);
  }
  return {};
}

Result<void> TailFile::append(std::span<const std::span<const std::byte>> parts) {
  for (const auto& part : parts) {
    if (auto compared = compare(part); !compared) return compared;
  }
  return {};
}

Result<void> TailFile::compare(std::span<const std::byte> bytes) {
  while (!bytes.empty() && !differs_) {
    const std::uint64_t some = std::min<std::uint64_t>({bytes.size(), kCompareBytes, size_ - position_});
    buffer_.resize(some);
    if (auto got = read(position_, buffer_); !got) return got;
    const auto mismatch = std::ranges::mismatch(buffer_, bytes.first(some)).in1;
    const auto same = static_cast<std::size_t>(mismatch - buffer_.begin());
    differs_ = same < some || some == 0;
    position_ += same;
    bytes = bytes.subspan(same);
  }
  if (tail_.size() + bytes.size() > kMostTailBytes) {
    return Error{ErrorCode::unsupported,
                 path_.string() + " differs too early from what it should be: recover it into a new file"};
  }
  tail_.insert(tail_.end(), bytes.begin(), bytes.end());
  return {};
}

Result<void> TailFile::write_all(int fd, std::uint64_t offset, std::span<const std::byte> bytes) const {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(fd, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return failure("cannot write", written < 0 ? errno : EIO);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
    offset += static_cast<std::uint64_t>(written);
  }
  return {};
}

Result<std::optional<std::filesystem::path>> TailFile::commit() {
  std::optional<std::filesystem::path> saved;
  const std::uint64_t new_size = position_ + tail_.size();
  if (tail_.empty() && new_size == size_) return saved;
  // Space for the new end first: when there is none, the file has not been touched.
  const bool reserved =
      ::fallocate(fd_, FALLOC_FL_KEEP_SIZE, static_cast<off_t>(position_), static_cast<off_t>(tail_.size())) == 0;
  if (!reserved && (errno == ENOSPC || errno == EDQUOT)) {
    return Error{ErrorCode::no_space, "no space for the end of " + path_.string() + ": free some space and recover again"};
  }
  if (position_ < size_) {
    auto old_end = save_old_end();
    if (!old_end) return old_end.error();
    saved = std::move(*old_end);
  }
  // Cut first: at no time does an old piece stand behind a new one.
  if (::ftruncate(fd_, static_cast<off_t>(position_)) != 0) return failure("cannot shorten", errno);
  if (auto written = write_all(fd_, position_, tail_); !written) return written.error();
  if (::ftruncate(fd_, static_cast<off_t>(new_size)) != 0)
    return failure("cannot shorten", errno);  // gives back what was reserved
  if (::fsync(fd_) != 0) return failure("cannot write", errno);
  return saved;
}

/// On the disk before anything is cut off.
Result<std::filesystem::path> TailFile::save_old_end() const {
  for (int number = 1;; ++number) {
    std::filesystem::path name = path_;
    name += number == 1 ? ".torn" : ".torn" + std::to_string(number);
    auto out = mcap::FileWritable::create(name);
    if (!out && out.error().code == ErrorCode::invalid_argument) continue;  // there is one already
    if (!out) return out.error();
    std::vector<std::byte> piece;
    Result<void> done;
    (*out)->begin_closing();  // no space is to be kept back
    for (std::uint64_t at = position_; at < size_ && done; at += piece.size()) {
      piece.resize(std::min(kCompareBytes, size_ - at));
      done = const_cast<TailFile*>(this)->read(at, piece);
      const std::span<const std::byte> parts[] = {piece};
      if (done) done = (*out)->append(parts);
    }
    if (done) done = (*out)->close();
    if (done) return name;
    std::error_code ignored;
    std::filesystem::remove(name, ignored);
    return done.error();
  }
}

}  // namespace roseau::recorder
