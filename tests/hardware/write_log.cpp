#include "tests/hardware/write_log.h"

#include <gtest/gtest.h>

#include <fstream>

namespace roseau::testing {

namespace {

// Documentation/admin-guide/device-mapper/log-writes.rst, and qemu's block/blklogwrites.c.
constexpr std::uint64_t kMagic = 0x6a736677736872ULL;
constexpr std::uint64_t kFlushFlag = 1;
constexpr std::uint64_t kWriteThroughFlag = 2;
constexpr std::uint64_t kDiscardFlag = 4;

struct Superblock {
  std::uint64_t magic;
  std::uint64_t version;
  std::uint64_t entries;
  std::uint32_t sector_bytes;
} __attribute__((packed));

struct Entry {
  std::uint64_t sector;
  std::uint64_t sectors;
  std::uint64_t flags;
  std::uint64_t mark_bytes;
} __attribute__((packed));

template <class T>
bool read(std::ifstream& file, std::uint64_t offset, T& to) {
  file.seekg(static_cast<std::streamoff>(offset));
  return static_cast<bool>(file.read(reinterpret_cast<char*>(&to), sizeof to));
}

void write(std::fstream& image, const WriteLog::Write& one) {
  image.seekp(static_cast<std::streamoff>(one.offset));
  image.write(reinterpret_cast<const char*>(one.data.data()), static_cast<std::streamsize>(one.data.size()));
}

std::fstream open_image(const std::filesystem::path& image) {
  std::fstream file(image, std::ios::binary | std::ios::in | std::ios::out);
  EXPECT_TRUE(file) << image;
  return file;
}

}  // namespace

std::vector<std::string> logged_virtio_disk(const std::filesystem::path& image, const std::filesystem::path& log) {
  std::ofstream(log).close();
  return {"-blockdev", "driver=file,node-name=disk_file,filename=" + image.string(), "-blockdev",
          "driver=file,node-name=log_file,filename=" + log.string(),
          // Its head counts the entries: kept up to date, because the machine will be stopped dead.
          "-blockdev", "driver=blklogwrites,node-name=disk,file=disk_file,log=log_file,log-super-update-interval=1", "-device",
          "virtio-blk-pci,drive=disk,write-cache=on"};
}

WriteLog read_write_log(const std::filesystem::path& path) {
  WriteLog log;
  std::ifstream file(path, std::ios::binary);
  Superblock head{};
  if (!read(file, 0, head) || head.magic != kMagic) {
    ADD_FAILURE() << path << " is no log of writes";
    return log;
  }
  std::uint64_t position = head.sector_bytes;
  bool flush = false;
  for (std::uint64_t i = 0; i < head.entries; ++i) {
    Entry entry{};
    if (!read(file, position, entry)) break;
    position += head.sector_bytes;
    flush |= (entry.flags & kFlushFlag) != 0;
    const std::uint64_t bytes = entry.sectors * head.sector_bytes;
    if (bytes == 0 || (entry.flags & kDiscardFlag) != 0) continue;
    WriteLog::Write write{.offset = entry.sector * head.sector_bytes,
                          .data = std::vector<std::byte>(bytes),
                          .flushes_before = flush,
                          .durable = (entry.flags & kWriteThroughFlag) != 0};
    flush = false;
    file.seekg(static_cast<std::streamoff>(position));
    if (!file.read(reinterpret_cast<char*>(write.data.data()), static_cast<std::streamsize>(write.data.size()))) break;
    position += bytes;
    log.writes.push_back(std::move(write));
  }
  return log;
}

void apply_all(const WriteLog& log, std::size_t count, const std::filesystem::path& image) {
  auto file = open_image(image);
  for (std::size_t i = 0; i < count; ++i) write(file, log.writes[i]);
}

void apply_flushed_and_some(const WriteLog& log, std::size_t count, const std::filesystem::path& image, std::mt19937& random) {
  std::size_t flushed = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (log.writes[i].flushes_before) flushed = i;
  }
  auto file = open_image(image);
  std::bernoulli_distribution survives(0.5);
  for (std::size_t i = 0; i < count; ++i) {
    if (i < flushed || log.writes[i].durable || survives(random)) write(file, log.writes[i]);
  }
}

}  // namespace roseau::testing
