// What recording costs: raw pictures into a session with every CRC, beside what this disk can take (O_DIRECT writes of aligned
// 4 MiB into a preallocated file, in turn with ours), beside plain write(2) of the same pixels, and beside the CRC alone. CPU
// is user and system time of the whole process, so that it does not depend on the disk or on who else is busy.
//
// And how long record() keeps its caller, the capture's thread, while the disk is written as fast as it can be, and while two
// cameras are recorded at their own rate; beside it, at the same moments, what only copying the sample takes: what the machine
// itself does to a thread (whoever else runs on it) is in both.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <new>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "bench/bench.h"
#include "core/frame.h"
#include "recorder/format/crc32.h"
#include "recorder/format/file_io.h"
#include "recorder/recorder.h"

namespace roseau::bench {

namespace {

constexpr std::uint32_t kWidth_px = 1280;
constexpr std::uint32_t kHeight_px = 1024;
constexpr std::size_t kFrameBytes = std::size_t{kWidth_px} * kHeight_px;
constexpr std::size_t kBuffers = 64;  // 84 MB: more than caches hold, as with real cameras
constexpr int kFrames = 1000;
constexpr int kRounds = 5;
constexpr double kMegabytes = kFrames * double{kFrameBytes} * 1e-6;
constexpr double kFrameRate_hz = 60;  // of each of two cameras

double cpu_seconds() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double wall_seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

struct Rate {
  double cpu_s = 0;
  double wall_s = 0;
};

template <class Work>
Result<Rate> measure(Work work) {
  const double cpu_s = cpu_seconds();
  const double wall_s = wall_seconds();
  if (Result<void> done = work(); !done) return done.error();
  return Rate{cpu_seconds() - cpu_s, wall_seconds() - wall_s};
}

std::vector<Frame> noise_frames(FramePool& pool) {
  std::mt19937_64 random(1);
  std::vector<Frame> frames;
  for (std::size_t i = 0; i < kBuffers; ++i) {
    Frame frame{.pixels = pool.acquire(), .width = kWidth_px, .height = kHeight_px, .stride = kWidth_px};
    const auto pixels = frame.pixels.writable_bytes();
    for (std::size_t at = 0; at + 8 <= pixels.size(); at += 8) {
      const std::uint64_t noise = random();
      std::ranges::copy(std::as_bytes(std::span(&noise, 1)), pixels.begin() + static_cast<std::ptrdiff_t>(at));
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

Result<void> record(const std::vector<Frame>& frames, const std::filesystem::path& path) {
  StreamTable streams;
  const StreamId cameras[] = {streams.add({.topic = "/camera0/image", .kind = "frame", .device = "camera0"}),
                              streams.add({.topic = "/camera1/image", .kind = "frame", .device = "camera1"})};
  recorder::Recorder recorder(streams, {.queue_bytes = 64U << 20U, .wait_when_full = true});
  if (auto opened = recorder.open(path, {}); !opened) return opened;
  for (int i = 0; i < kFrames; ++i) {
    const HostTime time{from_seconds(1 + i / (2 * kFrameRate_hz))};
    const Sample sample{
        {.stream = cameras[i % 2], .sequence = static_cast<std::uint32_t>(i / 2), .arrival_time = time, .sample_time = time},
        frames[static_cast<std::size_t>(i) % frames.size()]};
    recorder.record(sample, time);
  }
  return recorder.close();
}

/// The same pixels by write(2), one call each, synced at the end as a session is.
Result<void> write_plainly(const std::vector<Frame>& frames, const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  bool whole = fd >= 0;
  for (int i = 0; i < kFrames && whole; ++i) {
    const auto bytes = frames[static_cast<std::size_t>(i) % frames.size()].bytes();
    whole = ::write(fd, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
  }
  whole = whole && ::fdatasync(fd) == 0;
  ::close(fd);
  if (!whole) return Error{ErrorCode::io, "cannot write " + path.string()};
  return {};
}

constexpr std::size_t kBlockBytes = 4U << 20U;
constexpr std::size_t kBlocks = kFrames * kFrameBytes / kBlockBytes;

struct AlignedDelete {
  void operator()(std::byte* bytes) const { ::operator delete[](bytes, std::align_val_t{kBlockBytes}); }
};
using AlignedBlock = std::unique_ptr<std::byte[], AlignedDelete>;

AlignedBlock noise_block() {
  AlignedBlock block(static_cast<std::byte*>(::operator new[](kBlockBytes, std::align_val_t{kBlockBytes})));
  static_cast<void>(::madvise(block.get(), kBlockBytes, MADV_HUGEPAGE));  // what is fastest
  std::mt19937 random(2);
  std::generate_n(block.get(), kBlockBytes, [&] { return static_cast<std::byte>(random()); });
  return block;
}

/// This disk's limit: nothing but whole blocks, straight to a file whose space is there already (that is not timed).
Result<Rate> write_directly(const AlignedBlock& block, const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_DIRECT, 0644);
  bool whole = fd >= 0 && ::posix_fallocate(fd, 0, static_cast<off_t>(kBlocks * kBlockBytes)) == 0;
  auto rate = measure([&]() -> Result<void> {
    for (std::size_t i = 0; i < kBlocks && whole; ++i) {
      whole = ::pwrite(fd, block.get(), kBlockBytes, static_cast<off_t>(i * kBlockBytes)) == ssize_t{kBlockBytes};
    }
    whole = whole && ::fdatasync(fd) == 0;
    return {};
  });
  ::close(fd);
  if (!whole)
    return Error{ErrorCode::io, "cannot write " + path.string() + " by O_DIRECT: name a directory on a real disk (--dir)"};
  return rate;
}

Result<void> sum(const std::vector<Frame>& frames) {
  std::uint32_t crc = 0;
  for (int i = 0; i < kFrames; ++i) crc = mcap::crc32(crc, frames[static_cast<std::size_t>(i) % frames.size()].bytes());
  if (crc == 0) return Error{ErrorCode::corrupt, "noise with a CRC of 0"};  // so that the sum is not optimised away
  return {};
}

// ---------------------------------------------------------------------------------------------------------------------
// How long record() takes

class Latencies {
 public:
  explicit Latencies(std::size_t expected) { us_.reserve(expected); }

  template <class Work>
  void time(Work work) {
    const auto before = std::chrono::steady_clock::now();
    work();
    us_.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - before).count());
  }
  void add_to(nlohmann::ordered_json& figures, const std::string& name) {
    std::ranges::sort(us_);
    const auto quantile = [this](double q) { return us_[static_cast<std::size_t>(q * static_cast<double>(us_.size() - 1))]; };
    figures[name + "_p50_us"] = quantile(0.5);
    figures[name + "_p99_us"] = quantile(0.99);
    figures[name + "_p999_us"] = quantile(0.999);
    figures[name + "_max_us"] = us_.back();
  }
  std::size_t count() const { return us_.size(); }

 private:
  std::vector<double> us_;
};

/// A capture thread with its cameras: every round a frame of each, and some results of other kinds.
class Capture {
 public:
  static constexpr int kOthersPerRound = 8;

  Capture(FramePool& pool, int rounds)
      : pool_(pool),
        enqueued(static_cast<std::size_t>(rounds) * (2 + kOthersPerRound)),
        copied(static_cast<std::size_t>(rounds) * (2 + kOthersPerRound)) {}

  Result<void> open(const std::filesystem::path& path) {
    // As in a live session: whoever is too fast loses samples, and the pool is smaller than the queue.
    recorder_ = std::make_unique<recorder::Recorder>(streams_, recorder::RecorderOptions{.queue_bytes = 256U << 20U});
    return recorder_->open(path, {});
  }

  /// False: every buffer is still on its way to the disk.
  bool round() {
    if (pool_.free_count() < 2) return false;
    const HostTime time{from_seconds(1 + round_ / kFrameRate_hz)};
    const auto number = static_cast<std::uint32_t>(round_++);
    for (const StreamId camera : cameras_) {
      pass({{.stream = camera, .sequence = number, .arrival_time = time, .sample_time = time},
            Frame{.pixels = pool_.acquire(), .width = kWidth_px, .height = kHeight_px, .stride = kWidth_px}},
           time);
    }
    for (std::uint32_t i = 0; i < kOthersPerRound; ++i) {
      pass({{.stream = target_, .sequence = number * kOthersPerRound + i, .arrival_time = time, .sample_time = time},
            Displacement{.x = 1, .y = 2}},
           time);
    }
    return true;
  }

  Result<void> close() {
    auto closed = recorder_->close();
    for (const auto& [topic, counters] : recorder_->state().streams) {
      if (counters.recorded != counters.received) return Error{ErrorCode::io, topic + " was not recorded whole"};
    }
    return closed;
  }

 private:
  void pass(const Sample& sample, HostTime time) {
    enqueued.time([&] { recorder_->record(sample, time); });
    copied.time([&] { copies_[copy_++ % copies_.size()] = sample; });
    copies_[(copy_ - 1) % copies_.size()].payload = RawBytes{};  // the frame's buffer is not kept from its pool
  }

  FramePool& pool_;
  StreamTable streams_;
  std::vector<StreamId> cameras_ = {streams_.add({.topic = "/camera0/image", .kind = "frame", .device = "camera0"}),
                                    streams_.add({.topic = "/camera1/image", .kind = "frame", .device = "camera1"})};
  StreamId target_ = streams_.add({.topic = "/camera0/target/branch/displacement", .kind = "displacement"});
  std::unique_ptr<recorder::Recorder> recorder_;
  std::vector<Sample> copies_ = std::vector<Sample>(256);
  std::size_t copy_ = 0;
  int round_ = 0;

 public:
  Latencies enqueued;
  Latencies copied;
};

/// As fast as the disk takes it: there is always a frame waiting.
Result<void> time_at_full_rate(FramePool& pool, const std::filesystem::path& path, nlohmann::ordered_json& figures) {
  constexpr int kRoundsAtFullRate = 2000;
  Capture capture(pool, kRoundsAtFullRate);
  if (auto opened = capture.open(path); !opened) return opened;
  const double begin_s = wall_seconds();
  for (int done = 0; done < kRoundsAtFullRate;) {
    if (capture.round()) {
      ++done;
    } else {
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
  }
  auto closed = capture.close();
  figures["full_rate_megabytes_per_s"] = 2 * kRoundsAtFullRate * double{kFrameBytes} * 1e-6 / (wall_seconds() - begin_s);
  capture.enqueued.add_to(figures, "full_rate_enqueue");
  capture.copied.add_to(figures, "floor_full_rate_enqueue");
  return closed;
}

Result<void> time_two_cameras(FramePool& pool, const std::filesystem::path& path, nlohmann::ordered_json& figures) {
  constexpr int kRoundsAtRate = 20 * static_cast<int>(kFrameRate_hz);
  Capture capture(pool, kRoundsAtRate);
  if (auto opened = capture.open(path); !opened) return opened;
  auto next = std::chrono::steady_clock::now();
  int missed = 0;
  for (int done = 0; done < kRoundsAtRate; ++done) {
    std::this_thread::sleep_until(
        next += std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(1 / kFrameRate_hz)));
    if (!capture.round()) ++missed;
  }
  auto closed = capture.close();
  figures["two_cameras_60_hz_frames_missed_count"] = 2 * missed;
  capture.enqueued.add_to(figures, "two_cameras_60_hz_enqueue");
  capture.copied.add_to(figures, "floor_two_cameras_60_hz_enqueue");
  return closed;
}

// ---------------------------------------------------------------------------------------------------------------------

/// What was done before, and the removal of its file, is no part of the next measurement.
void settle_disk() {
  const int fd = ::open(work_directory().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  static_cast<void>(::syncfs(fd));
  ::close(fd);
}

Rate median(std::vector<Rate> rates) {
  std::ranges::sort(rates, {}, &Rate::cpu_s);
  Rate median{.cpu_s = rates[rates.size() / 2].cpu_s};
  std::ranges::sort(rates, {}, &Rate::wall_s);
  median.wall_s = rates[rates.size() / 2].wall_s;
  return median;
}

Result<nlohmann::ordered_json> run() {
  FramePool pool(kBuffers, kFrameBytes);
  auto frames = noise_frames(pool);
  const AlignedBlock block = noise_block();
  const auto path = work_directory() / ("roseau-bench-record-" + std::to_string(::getpid()) + ".mcap");
  // Ours and the limit in turn, so that they meet the same disk; then the others, whose dirty pages would be in their way.
  std::vector<Rate> recorded;
  std::vector<Rate> limit;
  std::vector<Rate> plain;
  std::vector<Rate> summed;
  using Works = std::vector<std::pair<std::vector<Rate>&, std::function<Result<Rate>()>>>;
  const Works in_turn[] = {{
                               {recorded, [&] { return measure([&] { return record(frames, path); }); }},
                               {limit, [&] { return write_directly(block, path); }},
                           },
                           {
                               {plain, [&] { return measure([&] { return write_plainly(frames, path); }); }},
                               {summed, [&] { return measure([&] { return sum(frames); }); }},
                           }};
  for (const Works& works : in_turn) {
    for (int round = 0; round < kRounds; ++round) {
      for (const auto& [rates, work] : works) {
        settle_disk();
        auto rate = work();
        std::error_code ignored;
        std::filesystem::remove(path, ignored);
        if (!rate) return rate.error();
        rates.push_back(*rate);
      }
    }
  }
  const Rate record_rate = median(recorded);
  const Rate limit_rate = median(limit);
  const Rate plain_rate = median(plain);
  const Rate crc_rate = median(summed);
  constexpr double kLimitMegabytes = kBlocks * double{kBlockBytes} * 1e-6;
  const double record_per_s = kMegabytes / record_rate.wall_s;
  const double limit_per_s = kLimitMegabytes / limit_rate.wall_s;
  nlohmann::ordered_json figures{
      {"case", "record"},
      {"frame_bytes", kFrameBytes},
      {"frames_count", kFrames},
      {"throughput_megabytes_per_cpu_s", kMegabytes / record_rate.cpu_s},
      {"reference_throughput_megabytes_per_cpu_s", kMegabytes / plain_rate.cpu_s},
      {"throughput_megabytes_per_s", record_per_s},
      {"limit_throughput_megabytes_per_s", limit_per_s},
      {"share_of_limit_percent", 100 * record_per_s / limit_per_s},
      {"reference_throughput_megabytes_per_s", kMegabytes / plain_rate.wall_s},
      {"crc_megabytes_per_cpu_s", kMegabytes / crc_rate.cpu_s},
      {"two_cameras_60_hz_cores", 2 * kFrameRate_hz * kFrameBytes * 1e-6 / (kMegabytes / record_rate.cpu_s)},
  };
  frames.clear();  // the captures take their buffers
  for (const auto& time : {time_at_full_rate, time_two_cameras}) {
    settle_disk();
    auto timed = time(pool, path, figures);
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    if (!timed) return timed.error();
  }
  return figures;
}

}  // namespace

void add_recording_cases(std::vector<Case>& cases) {
  cases.push_back({"record",
                   "recording raw pictures: CPU, wall time beside the disk's limit, how long callers wait; files go to --dir",
                   run});
}

}  // namespace roseau::bench
