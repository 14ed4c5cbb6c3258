#include "recorder/control/copy_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>

#include "recorder/format/crc32.h"

namespace roseau::recorder {

namespace {

constexpr std::string_view kGrowing = ".copying";
constexpr std::size_t kBlock = 4096;  // of O_DIRECT: offsets, sizes and memory

Error failure(const char* what, const std::filesystem::path& path, int error_number) {
  ErrorCode code = ErrorCode::io;
  if (error_number == ENOSPC || error_number == EDQUOT) code = ErrorCode::no_space;
  if (error_number == EROFS || error_number == EACCES || error_number == EPERM) code = ErrorCode::permission;
  return {code, std::string(what) + " " + path.string() + ": " + std::strerror(error_number)};
}

struct AlignedDelete {
  void operator()(std::byte* bytes) const { ::operator delete[](bytes, std::align_val_t{kBlock}); }
};

class DiskCopyFile final : public CopyFile {
 public:
  DiskCopyFile(int fd, std::filesystem::path growing, std::filesystem::path final_path)
      : fd_(fd), growing_(std::move(growing)), final_(std::move(final_path)) {
    direct_fd_ = ::open(growing_.c_str(), O_RDONLY | O_DIRECT | O_CLOEXEC);
  }
  ~DiskCopyFile() override {
    ::close(fd_);
    if (direct_fd_ >= 0) ::close(direct_fd_);
  }

  Result<void> write(std::uint64_t offset, std::span<const std::byte> bytes) override {
    while (!bytes.empty()) {
      const ssize_t written = ::pwrite(fd_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return failure("cannot write", growing_, written < 0 ? errno : EIO);
      bytes = bytes.subspan(static_cast<std::size_t>(written));
      offset += static_cast<std::uint64_t>(written);
    }
    return {};
  }

  Result<void> sync() override {
    if (::fdatasync(fd_) != 0) return failure("cannot write", growing_, errno);
    return {};
  }

  Result<void> read_back(std::uint64_t offset, std::span<std::byte> to) override {
    if (direct_fd_ >= 0) {
      const auto read = read_direct(offset, to);
      if (read || read.error().code != ErrorCode::unsupported) return read;
      ::close(std::exchange(direct_fd_, -1));
    }
    static_cast<void>(::posix_fadvise(fd_, static_cast<off_t>(offset), static_cast<off_t>(to.size()), POSIX_FADV_DONTNEED));
    while (!to.empty()) {
      const ssize_t got = ::pread(fd_, to.data(), to.size(), static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return failure("cannot read back", growing_, got < 0 ? errno : EIO);
      to = to.subspan(static_cast<std::size_t>(got));
      offset += static_cast<std::uint64_t>(got);
    }
    return {};
  }

  Result<void> finish(std::uint64_t bytes) override {
    if (::ftruncate(fd_, static_cast<off_t>(bytes)) != 0 || ::fsync(fd_) != 0) return failure("cannot write", growing_, errno);
    if (::rename(growing_.c_str(), final_.c_str()) != 0) return failure("cannot name", final_, errno);
    const int directory = ::open(final_.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (directory >= 0) {
      static_cast<void>(::fsync(directory));
      ::close(directory);
    }
    return {};
  }

 private:
  /// Whole blocks around what is asked for.
  Result<void> read_direct(std::uint64_t offset, std::span<std::byte> to) {
    const std::uint64_t begin = offset - offset % kBlock;
    const std::size_t wanted = static_cast<std::size_t>(offset - begin) + to.size();
    const std::size_t size = (wanted + kBlock - 1) / kBlock * kBlock;
    if (aligned_bytes_ < size) {
      aligned_.reset(static_cast<std::byte*>(::operator new[](size, std::align_val_t{kBlock})));
      aligned_bytes_ = size;
    }
    std::size_t have = 0;
    while (have < wanted) {
      const ssize_t got = ::pread(direct_fd_, aligned_.get() + have, size - have, static_cast<off_t>(begin + have));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0 && errno == EINVAL) return Error{ErrorCode::unsupported, "no O_DIRECT"};
      if (got <= 0) return failure("cannot read back", growing_, got < 0 ? errno : EIO);
      have += static_cast<std::size_t>(got);
    }
    std::memcpy(to.data(), aligned_.get() + (offset - begin), to.size());
    return {};
  }

  int fd_;
  int direct_fd_ = -1;
  std::filesystem::path growing_;
  std::filesystem::path final_;
  std::unique_ptr<std::byte[], AlignedDelete> aligned_;
  std::size_t aligned_bytes_ = 0;
};

class CopyDirectory final : public CopyDisk {
 public:
  explicit CopyDirectory(std::filesystem::path directory) : directory_(std::move(directory)) {}

  Result<std::unique_ptr<CopyFile>> create(const std::string& name) override {
    std::error_code error;
    std::filesystem::create_directories(directory_, error);
    if (error) return Error{ErrorCode::io, "cannot make " + directory_.string() + ": " + error.message()};
    const auto growing = directory_ / (name + std::string(kGrowing));
    const int fd = ::open(growing.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (fd < 0) return failure("cannot create", growing, errno);
    return std::unique_ptr<CopyFile>(std::make_unique<DiskCopyFile>(fd, growing, directory_ / name));
  }

  void remember(const std::string& name) override {
    const int fd = ::open((directory_ / (name + std::string(kGrowing))).c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
    if (fd >= 0) ::close(fd);
  }

  bool has(const std::string& name, std::uint64_t bytes) override {
    std::error_code error;
    return std::filesystem::file_size(directory_ / name, error) == bytes && !error;
  }

  std::vector<std::string> unfinished() override {
    std::vector<std::string> names;
    std::error_code error;
    for (std::filesystem::directory_iterator entry(directory_, error), end; !error && entry != end; entry.increment(error)) {
      if (entry->path().extension() == kGrowing) names.push_back(entry->path().stem().string());
    }
    std::ranges::sort(names);
    return names;
  }

 private:
  std::filesystem::path directory_;
};

}  // namespace

std::unique_ptr<CopyDisk> make_copy_directory(const std::filesystem::path& directory) {
  return std::make_unique<CopyDirectory>(directory);
}

std::uint32_t checksum(std::span<const std::byte> bytes) { return mcap::crc32(0, bytes); }

}  // namespace roseau::recorder
