// SecondCopy: a copy of every recording on a second disk, made while it is recorded, and read back from there.
//
// A thread of low priority follows the file that grows, and finished ones behind it. Every block is read once from the
// recording, written, forced to the disk, read back from there and compared by checksum. The recording never waits for it: a
// second disk that is slow, full or gone is said in the state, tried again, and everything that is still there is copied when
// it comes back.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/result.h"
#include "core/sample.h"
#include "recorder/control/copy_file.h"
#include "recorder/format/io.h"

namespace roseau::recorder {

/// Copies one file, as far as it is there. No thread of its own.
class FileCopier {
 public:
  static constexpr std::size_t kBlockBytes = std::size_t{4} << 20U;
  static constexpr std::size_t kBlocksPerCheck = 8;  // so many are written before they are read back

  FileCopier(std::filesystem::path source, CopyDisk& disk) : source_(std::move(source)), disk_(disk) {}

  /// Copies what there is below `available` bytes (whole blocks while `is_finished` is false), a few blocks at most, and
  /// verifies. True: there is more to do at once. After an Error the copy is begun anew.
  Result<bool> step(std::uint64_t available, bool is_finished);

  const std::filesystem::path& source() const { return source_; }
  std::uint64_t verified_bytes() const { return verified_; }
  bool is_done() const { return done_; }

 private:
  struct Block {
    std::uint64_t offset = 0;
    std::size_t bytes = 0;
    std::uint32_t checksum = 0;
  };
  Result<void> open();
  Result<void> copy_block(std::uint64_t offset, std::size_t bytes);
  Result<void> verify();
  Result<bool> advance(std::uint64_t available, bool is_finished);

  std::filesystem::path source_;
  CopyDisk& disk_;
  int source_fd_ = -1;
  struct CloseSource {
    int* fd;
    ~CloseSource();
  } close_source_{&source_fd_};
  std::unique_ptr<CopyFile> copy_;
  std::vector<std::byte> buffer_;
  std::vector<Block> unverified_;
  std::uint64_t copied_ = 0;
  std::uint64_t verified_ = 0;
  bool done_ = false;
};

/// Thread-safe.
class SecondCopy {
 public:
  /// `name` of the disk is for people. Files that an earlier run did not finish are taken up again, from `recordings`.
  SecondCopy(std::unique_ptr<CopyDisk> disk, std::string name, const std::filesystem::path& recordings,
             std::chrono::milliseconds retry = std::chrono::seconds(10));
  ~SecondCopy();
  SecondCopy(const SecondCopy&) = delete;
  SecondCopy& operator=(const SecondCopy&) = delete;

  /// The file that is being recorded, so far.
  void follow(const std::filesystem::path& file, std::uint64_t bytes);
  /// It is closed; or any file that is to be copied.
  void add_finished(const std::filesystem::path& file);
  /// A file of an earlier run, which may have been copied then.
  void add_unless_there(const std::filesystem::path& file);

  /// Waits until everything is copied, or the time is up, or the disk fails. True: everything is.
  bool finish(std::chrono::milliseconds at_most);

  /// Files whose copy is not verified yet: retention spares them while it can.
  std::vector<std::filesystem::path> unfinished() const;
  Health::Copy state() const;

 private:
  struct Job {
    std::filesystem::path file;
    std::uint64_t available = 0;
    std::uint64_t verified = 0;
    bool is_finished = false;
    bool may_be_there = false;   // look first
    bool is_remembered = false;  // on the second disk, for the next start
  };
  void add(const std::filesystem::path& file, bool may_be_there);
  void take_up_unfinished(const std::filesystem::path& recordings);
  void remember_new();
  void work(const std::stop_token& stop);
  Job* job_of(const std::filesystem::path& file);
  std::optional<Job> next_job() const;
  void note(const Job& job, const Result<bool>& stepped, const FileCopier& copier);
  void forget(const std::filesystem::path& file);

  const std::unique_ptr<CopyDisk> disk_;  // the thread's alone: a disk may hang, and nobody else may hang with it
  const std::chrono::milliseconds retry_;
  mutable std::mutex mutex_;
  std::condition_variable_any work_ready_;
  std::condition_variable changed_;
  std::deque<Job> jobs_;                  // oldest first
  std::set<std::filesystem::path> done_;  // a last word about how far a file was may come after it was closed and copied
  Health::Copy state_;
  std::uint64_t done_bytes_ = 0;  // of finished jobs
  bool has_failed_ = false;
  bool is_ready_ = false;  // knows what an earlier run did not finish
  std::jthread thread_;
};

}  // namespace roseau::recorder
