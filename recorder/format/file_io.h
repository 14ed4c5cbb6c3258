// MCAP files on disk. Every system call's result is checked: a full disk is an Error, never silence.
#pragma once

#include <sys/uio.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "recorder/format/direct_writer.h"
#include "recorder/format/io.h"

namespace roseau::mcap {

/// Appends to a new file: where the file system can, by O_DIRECT in large blocks and by a thread of its own (direct_writer.h);
/// else by plain writes, at once.
///
/// Space is reserved ahead of the end in large steps (where the file system can), so that a disk that fills up is noticed while
/// there is still room for the summary: `append` then fails with no_space, has written nothing, and after begin_closing() what
/// was kept back (`kReserveBytes` and what keep_back() asked for) may be used to close the file properly. What is reserved is
/// not seen in the file's size, not even after a crash or a power cut.
class FileWritable : public Writable {
 public:
  static constexpr std::uint64_t kReserveBytes = 4U << 20U;

  /// Makes the file; fails if it exists already (a session is never overwritten) or cannot be made.
  static Result<std::unique_ptr<FileWritable>> create(const std::filesystem::path& path);
  /// Takes over an open descriptor, for plain writes: a pipe, a device. `path` is for messages.
  static std::unique_ptr<FileWritable> adopt(int fd, std::string path);
  ~FileWritable() override;
  FileWritable(const FileWritable&) = delete;
  FileWritable& operator=(const FileWritable&) = delete;

  Result<void> append(std::span<const std::span<const std::byte>> parts) override;
  std::uint64_t written() const override;
  Result<void> flush() override;
  Result<void> sync() override;
  Result<void> begin_sync() override;
  void keep_back(std::uint64_t bytes) override { end_bytes_ = bytes; }

  void begin_closing() override { closing_ = true; }
  /// Also gives back what was reserved beyond the end.
  Result<void> close() override;

  /// All that was appended.
  std::uint64_t size() const { return size_; }

 private:
  FileWritable(int fd, std::string path) : fd_(fd), path_(std::move(path)) {}
  using Parts = std::span<const std::span<const std::byte>>;
  Result<void> write_parts(Parts parts);
  void take_back(std::uint64_t size_before, const Error& error);
  Result<void> write_all(std::span<iovec> parts);
  Result<void> reserve(std::uint64_t bytes);
  void start_writeback();
  Error failure(const char* what, int error_number) const;

  int fd_;
  std::string path_;
  int direct_fd_ = -1;                    // the same file, opened O_DIRECT; -1 where that cannot be
  std::unique_ptr<DirectWriter> direct_;  // from the first append on; none: plain writes
  std::uint64_t size_ = 0;
  std::uint64_t reserved_until_ = 0;
  std::uint64_t end_bytes_ = 0;
  std::uint64_t writeback_until_ = 0;
  bool can_reserve_ = true;
  bool closing_ = false;
  std::optional<Error> broken_;  // bytes of a failed append could not be taken back
};

class FileReadable : public Readable {
 public:
  static Result<std::unique_ptr<FileReadable>> open(const std::filesystem::path& path);
  ~FileReadable() override;
  FileReadable(const FileReadable&) = delete;
  FileReadable& operator=(const FileReadable&) = delete;

  std::uint64_t size() const override { return size_; }
  Result<void> read(std::uint64_t offset, std::span<std::byte> to) override;

 private:
  FileReadable(int fd, std::uint64_t size, std::string path) : fd_(fd), size_(size), path_(std::move(path)) {}
  int fd_;
  std::uint64_t size_;
  std::string path_;
};

}  // namespace roseau::mcap
