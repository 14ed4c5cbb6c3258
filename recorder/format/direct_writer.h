// DirectWriter: a growing file's bytes to the disk in large aligned blocks, past the page cache, by a thread of its own.
//
// append copies into one of a few buffers (the only copy on the way: O_DIRECT wants memory, offset and size in whole blocks,
// which records are not), and a full buffer is written while the next one is filled; so that the disk never waits for the
// processor. Syncs have a thread too: a flush of the disk's cache takes tens of milliseconds, in which writes go on.
//
// The file has its true size at any time: after a flush its last, unfinished block is written through the page cache, and
// again, directly, when it is full. What is in the buffers when the program dies is lost; flush() bounds how much that is.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "core/result.h"

namespace roseau::mcap {

/// One thread at a time, but for written().
class DirectWriter {
 public:
  /// How system calls that failed become Errors.
  using MakeError = Error (*)(const char* what, const std::string& path, int error_number);

  /// `fd` and `direct_fd` (O_DIRECT) are the same, empty file; they must stay open. `path` is for messages.
  DirectWriter(int fd, int direct_fd, std::string path, MakeError make_error);
  /// Gives up what was not written: drain first.
  ~DirectWriter();
  DirectWriter(const DirectWriter&) = delete;
  DirectWriter& operator=(const DirectWriter&) = delete;

  /// Waits when all buffers are full. Errors: of an earlier write or sync; they stay.
  Result<void> append(std::span<const std::span<const std::byte>> parts);
  /// Begins to write what is in the unfinished buffer.
  Result<void> flush();
  /// The same, and waits until everything is written.
  Result<void> drain();
  /// Begins to write everything and to sync it; does not wait.
  Result<void> begin_sync();

  std::uint64_t written() const { return written_.load(std::memory_order_acquire); }

 private:
  struct AlignedDelete {
    void operator()(std::byte* bytes) const;
  };
  using Buffer = std::unique_ptr<std::byte[], AlignedDelete>;
  struct Job {
    Buffer buffer;  // none: sync what was written before
    std::size_t bytes = 0;
    std::uint64_t offset = 0;
  };

  static Buffer make_buffer();
  Result<void> take_buffer();
  void submit();
  void write_jobs();
  void write(const Job& job);
  bool write_all(int fd, std::span<const std::byte> bytes, std::uint64_t offset);
  void sync_when_asked();
  void fail(int error_number);
  Result<void> state() const;  // the error, if there was one; mutex_ held

  const int fd_;
  const int direct_fd_;
  const std::string path_;
  const MakeError make_error_;

  // The caller's: the buffer that is being filled.
  Buffer buffer_;
  std::size_t filled_ = 0;
  std::uint64_t offset_ = 0;       // of the buffer in the file: whole blocks
  std::size_t filled_before_ = 0;  // of that, bytes that were handed over already with the buffer before

  bool direct_ = true;  // the writing thread's: false where O_DIRECT turned out to be one in name only
  std::uint64_t writeback_until_ = 0;
  std::atomic<std::uint64_t> written_{0};

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> jobs_;
  std::vector<Buffer> free_buffers_;
  std::size_t buffer_count_ = 0;
  std::optional<Error> error_;
  bool sync_wanted_ = false;
  bool ending_ = false;
  std::jthread write_thread_;
  std::jthread sync_thread_;
};

/// fdatasync, and a look whether the file system still takes writes: one that became read-only under us (a disk that was
/// unplugged or has errors) may take them into the page cache and even say that they were synced. 0, or errno.
int sync_file(int fd);

}  // namespace roseau::mcap
