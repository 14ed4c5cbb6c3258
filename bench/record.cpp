// What recording costs: raw pictures into a session with every CRC, beside plain write(2) of the same pixels, and beside the
// CRC alone. CPU is user and system time of the whole process, so that it does not depend on the disk or on who else is busy.
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <random>
#include <string>
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
constexpr int kFrames = 600;
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

Result<void> sum(const std::vector<Frame>& frames) {
  std::uint32_t crc = 0;
  for (int i = 0; i < kFrames; ++i) crc = mcap::crc32(crc, frames[static_cast<std::size_t>(i) % frames.size()].bytes());
  if (crc == 0) return Error{ErrorCode::corrupt, "noise with a CRC of 0"};  // so that the sum is not optimised away
  return {};
}

Rate median(std::vector<Rate> rates) {
  std::ranges::sort(rates, {}, &Rate::cpu_s);
  return rates[rates.size() / 2];
}

Result<nlohmann::ordered_json> run() {
  FramePool pool(kBuffers, kFrameBytes);
  const auto frames = noise_frames(pool);
  const auto path = work_directory() / ("roseau-bench-record-" + std::to_string(::getpid()) + ".mcap");
  // In turn, so that all three meet the same machine.
  std::vector<Rate> recorded;
  std::vector<Rate> plain;
  std::vector<Rate> summed;
  const std::pair<std::vector<Rate>&, std::function<Result<void>()>> works[] = {
      {recorded, [&] { return record(frames, path); }},
      {plain, [&] { return write_plainly(frames, path); }},
      {summed, [&] { return sum(frames); }},
  };
  for (int round = 0; round < kRounds; ++round) {
    for (const auto& [rates, work] : works) {
      auto rate = measure(work);
      std::error_code ignored;
      std::filesystem::remove(path, ignored);
      if (!rate) return rate.error();
      rates.push_back(*rate);
    }
  }
  const Rate record_rate = median(recorded);
  const Rate plain_rate = median(plain);
  const Rate crc_rate = median(summed);
  return nlohmann::ordered_json{
      {"case", "record"},
      {"frame_bytes", kFrameBytes},
      {"frames_count", kFrames},
      {"throughput_megabytes_per_cpu_s", kMegabytes / record_rate.cpu_s},
      {"reference_throughput_megabytes_per_cpu_s", kMegabytes / plain_rate.cpu_s},
      {"throughput_megabytes_per_s", kMegabytes / record_rate.wall_s},
      {"reference_throughput_megabytes_per_s", kMegabytes / plain_rate.wall_s},
      {"crc_megabytes_per_cpu_s", kMegabytes / crc_rate.cpu_s},
      {"two_cameras_60_hz_cores", 2 * kFrameRate_hz * kFrameBytes * 1e-6 / (kMegabytes / record_rate.cpu_s)},
  };
}

}  // namespace

void add_recording_cases(std::vector<Case>& cases) {
  cases.push_back({"record", "CPU of recording raw pictures, beside plain write(2); files go to --dir", run});
}

}  // namespace roseau::bench
