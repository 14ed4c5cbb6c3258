// Where a verified copy goes: a file on a second disk, written in order and read back from the disk itself. An interface, so
// that tests can have a disk that fails.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"

namespace roseau::recorder {

/// One copy that grows. While it does, its name ends in ".copying".
class CopyFile {
 public:
  virtual ~CopyFile() = default;
  virtual Result<void> write(std::uint64_t offset, std::span<const std::byte> bytes) = 0;
  /// What was written would survive a power cut.
  virtual Result<void> sync() = 0;
  /// What is on the disk, not what the system remembers of it, where that can be had. Only what was synced.
  virtual Result<void> read_back(std::uint64_t offset, std::span<std::byte> to) = 0;
  /// It is whole and right: gives it its name.
  virtual Result<void> finish(std::uint64_t bytes) = 0;
};

class CopyDisk {
 public:
  virtual ~CopyDisk() = default;
  /// Begins the copy called `name` anew.
  virtual Result<std::unique_ptr<CopyFile>> create(const std::string& name) = 0;
  /// Notes that a copy of `name` is wanted, for the next start should this one not come to it.
  virtual void remember(const std::string& name) = 0;
  /// Whether there is a finished copy of that size.
  virtual bool has(const std::string& name, std::uint64_t bytes) = 0;
  /// Names of copies that were wanted or begun and never finished.
  virtual std::vector<std::string> unfinished() = 0;
};

/// A directory, which is made if need be; reads back with O_DIRECT, and where the file system has none, after telling the
/// system to forget the pages.
std::unique_ptr<CopyDisk> make_copy_directory(const std::filesystem::path& directory);

/// CRC-32 as in the files.
std::uint32_t checksum(std::span<const std::byte> bytes);

}  // namespace roseau::recorder
