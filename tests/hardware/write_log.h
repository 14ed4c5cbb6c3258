// A disk whose writes are logged by qemu (driver blklogwrites, the format of Linux' dm-log-writes), and disks made of the log
// as a power cut might have left them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace roseau::testing {

/// The arguments that give the machine a virtio disk (/dev/vda) with a write cache, whose writes are logged to `log`.
std::vector<std::string> logged_virtio_disk(const std::filesystem::path& image, const std::filesystem::path& log);

struct WriteLog {
  struct Write {
    std::uint64_t offset = 0;  // on the disk, bytes
    std::vector<std::byte> data;
    bool flushes_before = false;  // the disk was told to make everything before this durable
    bool durable = false;         // itself written through
  };
  std::vector<Write> writes;
};
WriteLog read_write_log(const std::filesystem::path& path);

/// The first `count` writes, all of them.
void apply_all(const WriteLog& log, std::size_t count, const std::filesystem::path& image);
/// Of the first `count` writes those before the last flush and those written through; of the others a random half.
void apply_flushed_and_some(const WriteLog& log, std::size_t count, const std::filesystem::path& image, std::mt19937& random);

}  // namespace roseau::testing
