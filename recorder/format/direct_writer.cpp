#include "recorder/format/direct_writer.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <utility>

namespace roseau::mcap {

namespace {

// O_DIRECT wants offsets, sizes and memory in whole blocks: 4096 does for every disk.
constexpr std::size_t kBlockBytes = 4096;
constexpr std::size_t kBufferBytes = 4U << 20U;  // disks reach their full rate with this, and hardly more with more
constexpr std::size_t kHugePageBytes = 2U << 20U;
constexpr std::size_t kMostBuffers = 4;                 // one is filled, one written, the others take up unevenness
constexpr std::size_t kLeastDirectBytes = 256U << 10U;  // below, the page cache is cheaper
constexpr std::uint64_t kWritebackStep = 8U << 20U;

}  // namespace

int sync_file(int fd) {
  if (::fdatasync(fd) != 0 && errno != EINVAL) return errno;  // EINVAL: not a file that can be synced
  struct statvfs file_system {};
  return ::fstatvfs(fd, &file_system) == 0 && (file_system.f_flag & ST_RDONLY) != 0 ? EROFS : 0;
}

void DirectWriter::AlignedDelete::operator()(std::byte* bytes) const {
  ::operator delete[](bytes, std::align_val_t{kHugePageBytes});
}

/// Of huge pages where the system has some: a write then is a few pieces of memory for the disk, not a thousand (measured: 1.4
/// times as fast).
DirectWriter::Buffer DirectWriter::make_buffer() {
  Buffer buffer(static_cast<std::byte*>(::operator new[](kBufferBytes, std::align_val_t{kHugePageBytes})));
  static_cast<void>(::madvise(buffer.get(), kBufferBytes, MADV_HUGEPAGE));
  return buffer;
}

DirectWriter::DirectWriter(int fd, int direct_fd, std::string path, MakeError make_error)
    : fd_(fd),
      direct_fd_(direct_fd),
      path_(std::move(path)),
      make_error_(make_error),
      buffer_(make_buffer()),
      buffer_count_(1) {
  write_thread_ = std::jthread([this] { write_jobs(); });
  sync_thread_ = std::jthread([this] { sync_when_asked(); });
}

DirectWriter::~DirectWriter() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
    jobs_.clear();
  }
  changed_.notify_all();
}

Result<void> DirectWriter::state() const {
  if (error_) return *error_;
  return {};
}

Result<void> DirectWriter::append(std::span<const std::span<const std::byte>> parts) {
  {
    const std::scoped_lock lock(mutex_);
    if (error_) return *error_;
  }
  for (auto part : parts) {
    while (!part.empty()) {
      const auto some = part.first(std::min(part.size(), kBufferBytes - filled_));
      std::memcpy(buffer_.get() + filled_, some.data(), some.size());
      filled_ += some.size();
      part = part.subspan(some.size());
      if (filled_ < kBufferBytes) continue;
      submit();
      if (auto taken = take_buffer(); !taken) return taken;
    }
  }
  return {};
}

void DirectWriter::submit() {
  const std::scoped_lock lock(mutex_);
  jobs_.push_back({std::move(buffer_), filled_, offset_});
  offset_ += filled_;
  filled_ = filled_before_ = 0;
  changed_.notify_all();
}

Result<void> DirectWriter::take_buffer() {
  std::unique_lock lock(mutex_);
  if (free_buffers_.empty() && buffer_count_ < kMostBuffers) {
    ++buffer_count_;
    free_buffers_.push_back(make_buffer());
  }
  changed_.wait(lock, [this] { return !free_buffers_.empty(); });  // after a failure they come back unwritten
  buffer_ = std::move(free_buffers_.back());
  free_buffers_.pop_back();
  return state();
}

/// The unfinished block at the end is begun again in the next buffer: it can be written directly only as a whole.
Result<void> DirectWriter::flush() {
  if (filled_ == filled_before_) {
    const std::scoped_lock lock(mutex_);
    return state();
  }
  const std::size_t rest = filled_ % kBlockBytes;
  std::byte tail[kBlockBytes];
  std::memcpy(tail, buffer_.get() + filled_ - rest, rest);
  submit();
  auto taken = take_buffer();
  std::memcpy(buffer_.get(), tail, rest);
  filled_ = filled_before_ = rest;
  offset_ -= rest;
  return taken;
}

Result<void> DirectWriter::drain() {
  if (auto flushed = flush(); !flushed) return flushed;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return jobs_.empty(); });
  return state();
}

Result<void> DirectWriter::begin_sync() {
  if (auto flushed = flush(); !flushed) return flushed;
  const std::scoped_lock lock(mutex_);
  jobs_.push_back({});
  changed_.notify_all();
  return state();
}

void DirectWriter::write_jobs() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ending_ || !jobs_.empty(); });
    if (jobs_.empty()) return;
    Job& job = jobs_.front();  // stays where it is: a deque's front does not move when more is added
    if (!job.buffer) {
      sync_wanted_ = true;
    } else if (!error_) {
      lock.unlock();
      write(job);
      lock.lock();
    }
    if (ending_) return;
    if (job.buffer) free_buffers_.push_back(std::move(job.buffer));
    jobs_.pop_front();
    changed_.notify_all();
  }
}

void DirectWriter::write(const Job& job) {
  const std::span<const std::byte> bytes(job.buffer.get(), job.bytes);
  std::size_t whole = direct_ && job.bytes >= kLeastDirectBytes ? job.bytes - job.bytes % kBlockBytes : 0;
  if (whole > 0 && !write_all(direct_fd_, bytes.first(whole), job.offset)) {
    if (errno != EINVAL) return fail(errno);
    direct_ = false;
    whole = 0;
  }
  if (!write_all(fd_, bytes.subspan(whole), job.offset + whole)) return fail(errno);
  const std::uint64_t end = job.offset + job.bytes;
  written_.store(end, std::memory_order_release);
  if (direct_ || end - writeback_until_ < kWritebackStep) return;
  // The kernel would otherwise gather dirty pages for many seconds and then make one sync wait for all of them.
  const auto from = static_cast<off_t>(writeback_until_);
  static_cast<void>(::sync_file_range(fd_, from, static_cast<off_t>(end) - from, SYNC_FILE_RANGE_WRITE));
  writeback_until_ = end;
}

/// False: errno says why.
bool DirectWriter::write_all(int fd, std::span<const std::byte> bytes, std::uint64_t offset) {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(fd, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written == 0) errno = EIO;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
    offset += static_cast<std::uint64_t>(written);
  }
  return true;
}

void DirectWriter::fail(int error_number) {
  const std::scoped_lock lock(mutex_);
  if (!error_) error_ = make_error_("cannot write", path_, error_number);
}

void DirectWriter::sync_when_asked() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ending_ || sync_wanted_; });
    if (ending_) return;
    sync_wanted_ = false;
    lock.unlock();
    const int error_number = sync_file(fd_);
    if (error_number != 0) fail(error_number);
    lock.lock();
  }
}

}  // namespace roseau::mcap
