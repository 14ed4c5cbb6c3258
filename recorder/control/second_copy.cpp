#include "recorder/control/second_copy.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/log.h"

namespace roseau::recorder {

namespace {

Error read_failure(const std::filesystem::path& path, int error_number) {
  return {error_number == ENOENT ? ErrorCode::not_found : ErrorCode::io,
          "cannot read " + path.string() + ": " + std::strerror(error_number)};
}

/// Of the calling thread: only when nobody else wants the processor or the disk. Best effort.
void lower_priority() {
  const auto thread = static_cast<id_t>(::gettid());
  static_cast<void>(::setpriority(PRIO_PROCESS, thread, 19));
  constexpr int kWhoProcess = 1;
  constexpr int kClassIdle = 3 << 13;
  static_cast<void>(::syscall(SYS_ioprio_set, kWhoProcess, thread, kClassIdle));
}

}  // namespace

FileCopier::CloseSource::~CloseSource() {
  if (*fd >= 0) ::close(*fd);
}

Result<bool> FileCopier::step(std::uint64_t available, bool is_finished) {
  auto advanced = advance(available, is_finished);
  if (!advanced) {
    copy_.reset();
    unverified_.clear();
    copied_ = 0;
    verified_ = 0;
  }
  return advanced;
}

Result<bool> FileCopier::advance(std::uint64_t available, bool is_finished) {
  if (done_) return false;
  if (auto opened = open(); !opened) return opened.error();
  std::size_t blocks = 0;
  while (blocks < kBlocksPerCheck && copied_ < available) {
    const auto bytes = static_cast<std::size_t>(std::min<std::uint64_t>(kBlockBytes, available - copied_));
    if (bytes < kBlockBytes && !is_finished) break;
    if (auto copied = copy_block(copied_, bytes); !copied) return copied.error();
    copied_ += bytes;
    ++blocks;
  }
  if (auto verified = verify(); !verified) return verified.error();
  if (is_finished && verified_ == available) {
    if (auto finished = copy_->finish(available); !finished) return finished.error();
    copy_.reset();
    done_ = true;
    return false;
  }
  return blocks == kBlocksPerCheck;
}

Result<void> FileCopier::open() {
  if (source_fd_ < 0) source_fd_ = ::open(source_.c_str(), O_RDONLY | O_CLOEXEC);
  if (source_fd_ < 0) return read_failure(source_, errno);
  if (copy_) return {};
  auto created = disk_.create(source_.filename().string());
  if (!created) return created.error();
  copy_ = std::move(*created);
  return {};
}

Result<void> FileCopier::copy_block(std::uint64_t offset, std::size_t bytes) {
  buffer_.resize(kBlockBytes);
  const std::span<std::byte> block = std::span(buffer_).first(bytes);
  for (std::size_t have = 0; have < bytes;) {
    const ssize_t got = ::pread(source_fd_, block.data() + have, bytes - have, static_cast<off_t>(offset + have));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return read_failure(source_, got < 0 ? errno : EIO);
    have += static_cast<std::size_t>(got);
  }
  // Read once: it must not push anything out of memory that somebody else needs.
  static_cast<void>(::posix_fadvise(source_fd_, static_cast<off_t>(offset), static_cast<off_t>(bytes), POSIX_FADV_DONTNEED));
  if (auto written = copy_->write(offset, block); !written) return written;
  unverified_.push_back({offset, bytes, checksum(block)});
  return {};
}

Result<void> FileCopier::verify() {
  if (unverified_.empty()) return {};
  if (auto synced = copy_->sync(); !synced) return synced;
  for (const Block& block : unverified_) {
    const std::span<std::byte> back = std::span(buffer_).first(block.bytes);
    if (auto read = copy_->read_back(block.offset, back); !read) return read;
    if (checksum(back) != block.checksum) {
      return Error{ErrorCode::corrupt, "the second disk gives back other bytes than were written to it (" +
                                           source_.filename().string() + ", at byte " + std::to_string(block.offset) +
                                           "): replace that disk"};
    }
    verified_ = block.offset + block.bytes;
  }
  unverified_.clear();
  return {};
}

SecondCopy::SecondCopy(std::unique_ptr<CopyDisk> disk, std::string name, const std::filesystem::path& recordings,
                       std::chrono::milliseconds retry)
    : disk_(std::move(disk)), retry_(retry) {
  state_.directory = std::move(name);
  state_.state = DeviceState::running;
  thread_ = std::jthread([this, recordings](const std::stop_token& stop) {
    lower_priority();
    take_up_unfinished(recordings);
    work(stop);
  });
}

void SecondCopy::take_up_unfinished(const std::filesystem::path& recordings) {
  for (const std::string& unfinished : disk_->unfinished()) {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(recordings / unfinished, ignored)) add_finished(recordings / unfinished);
  }
  const std::scoped_lock lock(mutex_);
  is_ready_ = true;
  changed_.notify_all();
}

SecondCopy::~SecondCopy() = default;

SecondCopy::Job* SecondCopy::job_of(const std::filesystem::path& file) {
  const auto found = std::ranges::find(jobs_, file, &Job::file);
  return found == jobs_.end() ? nullptr : &*found;
}

void SecondCopy::follow(const std::filesystem::path& file, std::uint64_t bytes) {
  const std::scoped_lock lock(mutex_);
  if (done_.contains(file)) return;
  Job* job = job_of(file);
  if (job == nullptr) job = &jobs_.emplace_back(Job{.file = file});
  if (job->is_finished) return;
  job->available = std::max(job->available, bytes);
  work_ready_.notify_all();
}

void SecondCopy::add_finished(const std::filesystem::path& file) { add(file, /*may_be_there=*/false); }
void SecondCopy::add_unless_there(const std::filesystem::path& file) { add(file, /*may_be_there=*/true); }

void SecondCopy::add(const std::filesystem::path& file, bool may_be_there) {
  std::error_code error;
  const auto bytes = std::filesystem::file_size(file, error);
  const std::scoped_lock lock(mutex_);
  if (error) {
    forget(file);
    return;
  }
  Job* job = job_of(file);
  if (job == nullptr) job = &jobs_.emplace_back(Job{.file = file, .may_be_there = may_be_there});
  job->available = bytes;
  job->is_finished = true;
  work_ready_.notify_all();
}

/// Should this run not come to them, the next one will.
void SecondCopy::remember_new() {
  std::vector<std::string> names;
  {
    const std::scoped_lock lock(mutex_);
    for (Job& job : jobs_) {
      if (!std::exchange(job.is_remembered, true) && !job.may_be_there) names.push_back(job.file.filename().string());
    }
  }
  for (const std::string& name : names) disk_->remember(name);
}

void SecondCopy::forget(const std::filesystem::path& file) {
  std::erase_if(jobs_, [&](const Job& job) { return job.file == file; });
  changed_.notify_all();
}

/// The oldest file that has something to copy.
std::optional<SecondCopy::Job> SecondCopy::next_job() const {
  for (const Job& job : jobs_) {
    if (job.is_finished || job.available >= job.verified + FileCopier::kBlockBytes) return job;
  }
  return std::nullopt;
}

void SecondCopy::work(const std::stop_token& stop) {
  std::optional<FileCopier> copier;
  while (!stop.stop_requested()) {
    std::optional<Job> job;
    {
      std::unique_lock lock(mutex_);
      if (has_failed_) work_ready_.wait_for(lock, stop, retry_, [] { return false; });
      work_ready_.wait(lock, stop, [&] { return (job = next_job()).has_value(); });
    }
    if (!job || stop.stop_requested()) return;
    remember_new();
    if (job->may_be_there && disk_->has(job->file.filename().string(), job->available)) {
      const std::scoped_lock lock(mutex_);
      done_.insert(job->file);
      forget(job->file);
      continue;
    }
    if (!copier || copier->source() != job->file) copier.emplace(job->file, *disk_);
    const auto stepped = copier->step(job->available, job->is_finished);
    note(*job, stepped, *copier);
  }
}

void SecondCopy::note(const Job& job, const Result<bool>& stepped, const FileCopier& copier) {
  const std::scoped_lock lock(mutex_);
  if (Job* present = job_of(job.file); present != nullptr) present->verified = copier.verified_bytes();
  if (copier.is_done()) {
    done_bytes_ += copier.verified_bytes();
    done_.insert(job.file);
    forget(job.file);
  }
  if (stepped) {
    if (has_failed_) log("copy")->info("the copy to {} goes on", state_.directory);
    has_failed_ = false;
    state_.state = DeviceState::running;
    state_.message.clear();
  } else if (std::error_code error; !std::filesystem::exists(job.file, error) && !error) {
    log("copy")->warn("{} was deleted before it was copied to {}", job.file.string(), state_.directory);
    forget(job.file);
  } else {
    if (!has_failed_) log("copy")->error("{}", stepped.error().message);
    has_failed_ = true;
    state_.state = DeviceState::degraded;
    state_.message = stepped.error().message + ". The recording goes on; the copy is tried again";
  }
  changed_.notify_all();
}

bool SecondCopy::finish(std::chrono::milliseconds at_most) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, at_most, [this] { return is_ready_ && (jobs_.empty() || has_failed_); });
  return is_ready_ && jobs_.empty();
}

std::vector<std::filesystem::path> SecondCopy::unfinished() const {
  const std::scoped_lock lock(mutex_);
  std::vector<std::filesystem::path> files;
  for (const Job& job : jobs_) files.push_back(job.file);
  return files;
}

Health::Copy SecondCopy::state() const {
  const std::scoped_lock lock(mutex_);
  Health::Copy state = state_;
  state.verified_bytes = done_bytes_;
  for (const Job& job : jobs_) {
    state.verified_bytes += job.verified;
    state.behind_bytes += job.available - std::min(job.available, job.verified);
  }
  return state;
}

}  // namespace roseau::recorder
