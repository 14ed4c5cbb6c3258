// TailFile: an existing file whose end is written anew. What is appended must first repeat the file as it is; from the first
// byte that differs on it is held in memory, and takes the place of the old end in commit(). Until then nothing is changed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "recorder/format/io.h"

namespace roseau::recorder {

class TailFile : public mcap::Readable, public mcap::Writable {
 public:
  /// Errors: not found, permission, busy when a recorder has the file open.
  static Result<std::unique_ptr<TailFile>> open(const std::filesystem::path& path);
  ~TailFile() override;
  TailFile(const TailFile&) = delete;
  TailFile& operator=(const TailFile&) = delete;

  std::uint64_t size() const override { return size_; }
  Result<void> read(std::uint64_t offset, std::span<std::byte> to) override;

  Result<void> append(std::span<const std::span<const std::byte>> parts) override;
  Result<void> sync() override { return {}; }

  /// How many bytes of the file stay as they are.
  std::uint64_t kept_bytes() const { return position_; }
  /// The old end goes to a file of its own beside this one, then the new one is written and the file gets its new size. Gives
  /// the name of the file with the old end; nothing when there was none. When space runs out nothing has been changed.
  Result<std::optional<std::filesystem::path>> commit();

 private:
  TailFile(int fd, std::uint64_t size, std::filesystem::path path) : fd_(fd), size_(size), path_(std::move(path)) {}
  Error failure(const char* what, int error_number) const;
  Result<void> compare(std::span<const std::byte> bytes);
  Result<std::filesystem::path> save_old_end() const;
  Result<void> write_all(int fd, std::uint64_t offset, std::span<const std::byte> bytes) const;

  int fd_;
  std::uint64_t size_;
  std::filesystem::path path_;
  std::uint64_t position_ = 0;  // the same up to here
  bool differs_ = false;
  std::vector<std::byte> tail_;
  std::vector<std::byte> buffer_;
};

}  // namespace roseau::recorder
